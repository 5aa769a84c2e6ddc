# Counts the instructions of each part of the tick on the emulated Teensy, with board_load.py.
#
# A part is a method, replaced by one that counts. 6 cycles of ticks_cpu(): 5 instructions. Parts
# may be nested. The cost of counting is measured first and subtracted.

import array
import time

from gazelink.native import micropython

_TRIES = 200

ticks_cpu = time.ticks_cpu
ticks_diff = time.ticks_diff


class Parts:
    def __init__(self, most):
        self.names = []
        self.now = array.array("i", [0] * most)  # of this tick, cycles
        self.calls = array.array("i", [0] * most)
        self._worst = array.array("i", [0] * most)  # of the worst tick
        self._most = array.array("i", [0] * most)  # each part's own worst
        self._sum = array.array("i", [0] * most)  # of all ticks, 16 instructions
        self._worst_cycles = 0
        self._ticks = 0
        self._total = 0  # of all ticks, 16 instructions
        self._inside = 0  # cycles that counting adds to a part
        self._around = 0  # and the enclosing part
        self._calibrate()

    # Replace `holder.name`, a method that takes `words` arguments.
    def watch(self, holder, name, words, title):
        at = len(self.names)
        self.names.append(title)
        setattr(holder, name, _Counted(getattr(holder, name), at, self).call(words))

    # After each tick: `cycles` is the total time.
    def tick(self, cycles):
        now = self.now
        calls = self.calls
        # Counting happens within the tick: subtracted, so that the parts add up.
        for at in range(len(self.names)):
            cycles -= calls[at] * self._around
        self._ticks += 1
        self._total += cycles * 5 // 96
        worst = cycles > self._worst_cycles
        if worst:
            self._worst_cycles = cycles
        for at in range(len(self.names)):
            took = now[at] - calls[at] * self._inside
            self._sum[at] += took * 5 // 96
            if took > self._most[at]:
                self._most[at] = took
            if worst:
                self._worst[at] = took
            now[at] = 0
            calls[at] = 0

    def _calibrate(self):
        dummy = _Dummy()
        start = ticks_cpu()
        for _ in range(_TRIES):
            dummy.nothing(0)
        plain = ticks_diff(ticks_cpu(), start)
        self.watch(dummy, "nothing", 1, "")
        start = ticks_cpu()
        for _ in range(_TRIES):
            dummy.nothing(0)
        counted = ticks_diff(ticks_cpu(), start)
        self._inside = 0
        del self.names[-1]
        inside = self.now[0]
        self._around = (counted - plain) // _TRIES
        # The method's own time does not belong to counting.
        bare = _Dummy().nothing
        start = ticks_cpu()
        for _ in range(_TRIES):
            bare(0)
        self._inside = (inside - ticks_diff(ticks_cpu(), start)) // _TRIES
        self.now[0] = self.calls[0] = 0

    # [(title, in the worst tick, the most, the mean)], instructions; the whole tick comes last.
    def found(self):
        result = []
        for at, name in enumerate(self.names):
            result.append((name, self._worst[at] * 5 // 6, self._most[at] * 5 // 6, self._sum[at]))
        most = self._worst_cycles * 5 // 6
        result.append(("tick", most, most, self._total))
        ticks = max(1, self._ticks)
        return [(name, worst, most, 16 * mean // ticks) for name, worst, most, mean in result]


class _Counted:
    # Not a closure: called with more than five words one allocates.

    def __init__(self, f, at, parts):
        self._f = f
        self._at = at
        self._now = parts.now
        self._calls = parts.calls

    def call(self, words):
        return (self.w0, self.w1, self.w2, self.w3, self.w4, self.w5, self.w6)[words]

    @micropython.native
    def _count(self, start):
        took = ticks_diff(ticks_cpu(), start)
        self._now[self._at] += took
        self._calls[self._at] += 1

    @micropython.native
    def w0(self):
        start = ticks_cpu()
        result = self._f()
        self._count(start)
        return result

    @micropython.native
    def w1(self, a):
        start = ticks_cpu()
        result = self._f(a)
        self._count(start)
        return result

    @micropython.native
    def w2(self, a, b):
        start = ticks_cpu()
        result = self._f(a, b)
        self._count(start)
        return result

    @micropython.native
    def w3(self, a, b, c):
        start = ticks_cpu()
        result = self._f(a, b, c)
        self._count(start)
        return result

    @micropython.native
    def w4(self, a, b, c, d):
        start = ticks_cpu()
        result = self._f(a, b, c, d)
        self._count(start)
        return result

    @micropython.native
    def w5(self, a, b, c, d, e):
        start = ticks_cpu()
        result = self._f(a, b, c, d, e)
        self._count(start)
        return result

    @micropython.native
    def w6(self, a, b, c, d, e, f):
        start = ticks_cpu()
        result = self._f(a, b, c, d, e, f)
        self._count(start)
        return result


class _Dummy:
    @micropython.native
    def nothing(self, _a):
        return 0
