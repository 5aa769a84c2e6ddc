# Emergency latch: survives a reset (P11), even on flash that may fail.
#
# It is stored twice, because a full flash still deletes: the file LATCHED exists, or the file CLEAR
# is missing although KNOWN says that there was one. Either is enough. Each start rewrites KNOWN, so
# that flash that rejects writes is found before anybody drives.

LATCHED = "emergency"
CLEAR = "emergency_clear"
KNOWN = "emergency_known"

_RETRY_MS = 250
_RETRY_MAX_MS = 64000
_TICKS = 0x3FFFFFFF


# Whether the flash shows that the latch is set. A file that cannot be read counts as present.
def stands(board):
    if board.load(LATCHED) is not None:
        return True
    return board.load(KNOWN) is not None and board.load(CLEAR) is None


class EmergencyLatch:
    # `failed`: the flash rejected a write, its content is not proven.

    def __init__(self, board):
        self._board = board
        self._wait_ms = 0
        self._tried_at = 0
        self.stored = stands(board)
        self.failed = not self._proven(self.stored)

    # The latch as the safety core has it; `ticks` is the board's clock, `disarmed`: a flash write
    # stops the tick.
    def keep(self, latched, disarmed, ticks):
        if (latched == self.stored and not self.failed) or not disarmed:
            return
        if self._wait_ms and (ticks - self._tried_at) & _TICKS < self._wait_ms:
            return
        self._tried_at = ticks
        self.failed = not self._proven(latched)
        self.stored = stands(self._board)
        if self.failed:
            self._wait_ms = min(_RETRY_MAX_MS, max(_RETRY_MS, 2 * self._wait_ms))
        else:
            self._wait_ms = 0

    # Put it there, and read it back.
    def _proven(self, latched):
        try:
            if latched:
                self._latch()
            else:
                # CLEAR before KNOWN and before the latch goes: a power cut leaves it standing.
                if self._board.load(CLEAR) is None:
                    self._board.store(CLEAR, "clear")
                self._board.store(KNOWN, "known")
                if self._board.load(LATCHED) is not None:
                    self._board.remove(LATCHED)
            return stands(self._board) == latched
        except Exception:  # no space, no memory, worn out
            return False

    def _latch(self):
        if stands(self._board):
            return
        try:
            self._board.store(LATCHED, "latched")
        except Exception:
            self._board.remove(CLEAR)
