# Boot log: counts consecutive watchdog resets.
#
# It also sends the last message of a board that stops, in the FAULT message that every version of
# the host understands.

from gazeboard.core import limits
from gazeboard.io.storage import sealed, unsealed
from gazelink import frame, messages

_FILE = "watchdog_boots"
_REASON_AT = messages.FAULT.offsets["reason"]
_DETAIL_AT = messages.FAULT.offsets["detail"]
_KEY_AT = messages.MAINTENANCE.offsets["key"]
_CLEAR_AT = messages.MAINTENANCE.offsets["reason"]
_ENTER = 13
_WATCHDOG = 3
_REPEAT_MS = 500
OPENED = 1  # what last_words() ends with
CLEARED = 2
LIMIT = 3  # watchdog resets in a row after which the board stays in the REPL


# Is there a count that cannot be read? Then it restarts, and must be reported.
def damaged(board):
    stored = board.load(_FILE)
    return stored is not None and _count(stored) is None


# Consecutive watchdog resets up to this boot, counted in a small file; any other cause restarts
# the count, and so does an hour without one.
def watchdog_boots(board):
    if board.reset_cause != _WATCHDOG:
        forget(board)
        return 0
    count = (_count(board.load(_FILE) or "") or 0) + 1
    try:
        board.store(_FILE, sealed(str(count)))
    except Exception:
        pass  # the flash rejects writes: the app detects and reports it, too
    return count


# The count restarts.
def forget(board):
    if board.load(_FILE) is not None:
        removed(board, _FILE)


# Whether a small file is missing.
def removed(board, name):
    try:
        board.remove(name)
        return True
    except Exception:
        return False


def _count(stored):
    line = unsealed(stored)
    if line is None or not line.isdigit() or len(line) > 3:
        return None
    return int(line)


# One FAULT frame, in at most `tries` attempts: the host may not be there.
def send_fault(board, reason, detail, tries=10000):
    encoder = frame.Encoder()
    text = detail.encode()[:40]
    encoder.body[_REASON_AT] = reason
    for k in range(40):
        encoder.body[_DETAIL_AT + k] = text[k] if k < len(text) else 0
    end = encoder.finish(messages.FAULT, 0)
    at = 0
    while at < end:
        at = board.serial.write_some(encoder.wire, at, end)
        tries -= 1
        if tries <= 0:
            return False
    return True


# The last words again and again, until somebody opens the REPL (Enter, as mpremote sends it, or a
# MAINTENANCE frame) or clears the fault: a MAINTENANCE frame with the fault's reason, which is the
# caretaker's button, or 3 s at the chair's own. Returns CLEARED then. A host that only greets does
# neither.
def last_words(board, reason, detail):
    decoder = frame.Decoder()
    between = True  # frames: none of them begins with Enter before there is a session
    pressed_ms = None
    while True:
        send_fault(board, reason, detail)
        start_ms = board.ticks_ms()
        while board.ticks_diff(board.ticks_ms(), start_ms) < _REPEAT_MS:
            byte = board.serial.read_byte()
            if byte < 0:
                if board.button_pin() != 0:
                    pressed_ms = None
                elif pressed_ms is None:
                    pressed_ms = board.ticks_ms()
                elif board.ticks_diff(board.ticks_ms(), pressed_ms) >= limits.RESET_PRESS_MS:
                    return CLEARED
                continue
            if between and byte == _ENTER:
                return OPENED
            between = byte == 0
            if decoder.feed(byte) and _is_maintenance(decoder.buf):
                return CLEARED if decoder.buf[_CLEAR_AT] == reason else OPENED


def _is_maintenance(buf):
    if buf[messages.TYPE_AT] != messages.MAINTENANCE.type_id:
        return False
    key = 0
    for k in range(4):
        key |= buf[_KEY_AT + k] << (8 * k)
    return key == messages.MAINTENANCE_KEY
