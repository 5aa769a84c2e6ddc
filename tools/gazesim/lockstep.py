# What every chair in virtual time is made of: steps of a millisecond, a clock, files, a board that
# waits for the next step. Runs on MicroPython too.

from gazeboard.boards.virtual import VirtualBoard


class Steps:
    # `one_ms` lets a millisecond pass, `why` tells what is so.

    def run(self, ms: int) -> None:
        for _ in range(ms):
            self.one_ms()

    # ms until `condition` holds, at most `limit_ms`.
    def until(self, condition, limit_ms: int) -> int:
        for ms in range(limit_ms + 1):
            if condition():
                return ms
            self.one_ms()
        raise AssertionError("not within %d ms: %s" % (limit_ms, self.why()))


class Clock:
    def __init__(self, start_us=0):
        self.now_us = start_us

    def ticks_us(self):
        return self.now_us & 0x3FFFFFFF

    def ticks_diff(self, a, b):
        return ((a - b + 0x20000000) & 0x3FFFFFFF) - 0x20000000


class Files:
    def __init__(self):
        self.texts = {}

    def load(self, name):
        return self.texts.get(name)

    def store(self, name, text):
        self.texts[name] = text

    def remove(self, name):
        self.texts.pop(name, None)


class LockstepBoard(VirtualBoard):
    # Draws the same numbers each time, and allocates nothing.
    drawn = 0
    app = None  # what main.py gave it to run

    def __init__(self, bank, serial, files, boot_id, clock):
        super().__init__(bank, serial, files, boot_id, clock.ticks_us, clock.ticks_diff)

    def draw_nonce(self, nonce):
        LockstepBoard.drawn += 1
        for k in range(4):
            nonce[k] = (LockstepBoard.drawn * (37 + k)) & 0xFF

    def run(self, app):
        self.app = app
