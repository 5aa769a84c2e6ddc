# Profile check: whether the chair turns as the selected speed profile predicts.
#
# It compares the measured turn rate with the model's, in every motion that turns. Pure: one tick of
# 1 ms, no allocation, integers only.
#
# During ramps all profiles are alike; only a steady turn distinguishes them. Until a steady turn
# confirms a slow profile, the board assumes the fastest one. The confirmation expires soon: the
# driver can turn the chair's own knob whenever it stands, and even while it drives.

from array import array

from gazeboard.core import limits
from gazelink.const import const
from gazelink.native import micropython, ptr32

_SAMPLE_MS = const(10)
_AFTER_TICKS = const(4)  # a new sample's tick and the three after it have enough to do
_AGREES_MS = const(300)  # of steady turning within a quarter of the model's rate
_CONTRADICTS_MS = const(200)
_STANDS_Q4 = const(24)  # 1.5 degrees/s
_TURNS_Q10 = const(6144)  # 6 degrees/s: slower turning says little
_FASTER_Q10 = const(8192)  # and anything this much faster than half as much again contradicts


# Indices of the words:
_COUNT = const(0)  # of heading samples, and what is left of the wait after one
_WAIT = const(1)


class ProfileCheck:
    # model: the ChairModel of the selected profile, stepped by the motion.

    def __init__(self, model):
        self._model = model
        self._words = array("i", [-1, 0])
        self._model_q10 = 0  # its rate at the sample
        self._steady_ms = 0
        self._agrees_ms = 0
        self._contradicts_ms = 0
        self._left_ms = 0  # until trust lapses for want of a turn that confirms it; 0: none
        self._stood_ms = 0
        self._stuck_ms = 0
        self.agreed = False
        # The chair stands in spite of what would turn a quick one: turns may be given what the
        # selected profile needs to start.
        self.sluggish = False

    # After the motion's tick; `i` is an Inputs, the outputs are those of this tick.
    @micropython.viper
    def step(self, i, linear_permille: int, turn_permille: int):
        w = ptr32(self._words)
        if int(self._left_ms):
            self._lapse(linear_permille, turn_permille)
        wait = w[_WAIT]
        if wait == 0:
            count = int(i.heading_count)
            if count != w[_COUNT]:
                w[_COUNT] = count
                w[_WAIT] = _AFTER_TICKS
            return
        w[_WAIT] = wait - 1
        if wait == _AFTER_TICKS:
            self._model_q10 = self._model.seen_rate()
        if wait > 1:
            return
        self._judge(i, turn_permille)

    @micropython.native
    def _judge(self, i, turn_permille):
        model = self._model
        rate_q4 = i.rate_q4
        faulty = i.heading_faults
        size = abs(turn_permille)
        steady_ms = 0
        if size >= limits.TELLING_PERMILLE and model.steady():
            steady_ms = min(self._steady_ms + _SAMPLE_MS, 1000)
        else:
            self._agrees_ms = 0
        self._steady_ms = steady_ms
        if (
            size < limits.TRYING_PERMILLE
            or self.sluggish
            or faulty
            or not -_STANDS_Q4 < rate_q4 < _STANDS_Q4
        ):
            self._stuck_ms = 0
        else:
            self._stuck_ms += _SAMPLE_MS
            if self._stuck_ms >= limits.TRYING_MS:
                self.sluggish = True
                self._left_ms = limits.TRUST_MS
                self._stood_ms = 0
        if faulty:
            return
        rate_q10 = self._model_q10
        seen_q10 = rate_q4 << 6
        if rate_q10 < 0:
            rate_q10 = -rate_q10
            seen_q10 = -seen_q10
        faster_q10 = rate_q10 + (rate_q10 >> 1) + _FASTER_Q10
        if not -faster_q10 <= seen_q10 <= faster_q10:
            self._contradict()
        elif rate_q10 > _TURNS_Q10 and steady_ms > model.dead_ms:
            if abs(seen_q10 - rate_q10) <= rate_q10 >> 2:
                self._contradicts_ms = 0
                self._agrees_ms += _SAMPLE_MS
                if self._agrees_ms >= _AGREES_MS:
                    self._agrees_ms = 0
                    self._left_ms = limits.TRUST_MS
                    self._stood_ms = 0
                    self.agreed = True
            else:
                self._contradict()

    # Counted in ticks: it lapses also while no heading comes.
    @micropython.native
    def _lapse(self, linear_permille, turn_permille):
        standing = limits.STANDING_PERMILLE
        if -standing < linear_permille < standing and -standing < turn_permille < standing:
            self._stood_ms += 1
        else:
            self._stood_ms = 0
        self._left_ms -= 1
        if self._left_ms == 0 or self._stood_ms >= limits.TRUST_STANDING_MS:
            self._distrust()

    @micropython.native
    def _distrust(self):
        self.agreed = False
        self.sluggish = False
        self._left_ms = 0
        self._agrees_ms = 0

    @micropython.native
    def _contradict(self):
        self._agrees_ms = 0
        self._contradicts_ms = min(self._contradicts_ms + _SAMPLE_MS, _CONTRADICTS_MS)
        if self._contradicts_ms >= _CONTRADICTS_MS:
            self._distrust()
