"""Parts of the core's tick written plainly: attributes instead of machine words.

The twins of tests/firmware/test_tick_twins.py: what the board runs must decide as these do.
"""

# mypy: ignore-errors
from gazeboard.core import limits
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row


class PlainSpeedBound:
    """As SpeedBound."""

    # `update` is called every `period_ms`.

    def __init__(self, period_ms):
        """As there."""
        self._period_ms = period_ms
        self._peak = 0  # highest that an output of the last dead time asked for
        self._since = 0  # highest asked for since the peak was last renewed
        self._left_ms = 0  # until the peak is over
        self._ramp = 0
        self._bound = 0

    # One period; `permille` is the highest output of it in this direction, 0..1000, `stopping` a
    # Stopping. Returns the bound, units/s rounded up. 64 * 2400 units/s * 1000 stays in 31 bits.
    def update(self, stopping, permille):
        """As there."""
        bound = self._bound
        if permille == 0 and bound == 0:
            return 0
        asked = (permille * stopping.full * 64 + 999) // 1000
        if asked >= self._peak:
            self._peak = asked
            self._since = 0
            self._left_ms = stopping.dead_ms
        else:
            if asked > self._since:
                self._since = asked
            self._left_ms -= self._period_ms
            if self._left_ms < 0:
                self._peak = self._since
                self._since = asked
                self._left_ms = stopping.dead_ms
        peak = self._peak
        ramp = self._ramp
        # The lag first, behind the ramp as it was: both fall within the period.
        if bound > ramp:
            period_ms = self._period_ms
            fall = (bound - ramp) * period_ms // (stopping.tail_ms + period_ms)
            bound -= fall if fall else 1
        if ramp > peak:
            ramp = max(peak, ramp - stopping.brake * 64 * self._period_ms // 1000)
        elif ramp < peak:
            ramp = peak
        self._ramp = ramp
        self._bound = max(bound, ramp)
        return (self._bound + 64 - 1) >> 6


class PlainWay:
    """As Way."""

    def __init__(self):
        """As there."""
        self._bound = PlainSpeedBound(8)
        self._better_ms = 0
        self.level = -1
        self.rolls = 0
        self.speed = 0
        self.stop = 0

    # `permille` is the highest output since the last time, `measured` a speed that is seen.
    def feel(self, stopping, permille, measured):
        """As there."""
        speed = self._bound.update(stopping, permille)
        self.rolls = speed
        if measured > speed:
            speed = measured
        self.speed = speed
        # As Stopping.stop(): written out, a call is dear here.
        stop = stopping.margin
        if speed:
            stop += speed * stopping.time_ms // 1000 + speed * speed // stopping.two_brake
        self.stop = stop

    # `distance` was free `age_ms` ago; `ceiling` is the highest level that other things permit.
    # Down at once, up only after CLEAR_MS of a better view.
    def judge(self, stopping, distance, age_ms, ceiling):
        """As there."""
        begin = stopping.begin
        stop = self.stop
        level = self.level
        distance -= self.speed * age_ms // 1000
        if level > ceiling:
            level = ceiling
        if level >= 0 and (distance < stop or distance < begin[level]):
            level = _level(begin, distance) if distance >= stop else -1
        if level < self.level:
            self.level = level
            self._better_ms = 0
        elif level < ceiling:
            distance -= stopping.band
            if distance < stop or distance < begin[level + 1]:
                self._better_ms = 0
            else:
                self._better_ms += 8
                if self._better_ms >= 300:
                    self._better_ms = 0
                    self.level = min(ceiling, _level(begin, distance))


# The highest level whose distance is there; -1 for none.
def _level(begin, distance):
    """The highest level whose distance is there."""
    low = 0
    high = 16 + 1
    while low < high:
        middle = (low + high) >> 1
        if begin[middle] <= distance:
            low = middle + 1
        else:
            high = middle
    return low - 1


class PlainObedience:
    """As Obedience."""

    # settings: a Settings; configure() again whenever they change.

    def __init__(self, settings):
        """As there."""
        self._count = 0
        self._wait = 0
        self._left_q4 = 0  # the most it may be turning, 1/16 degree/s
        self._right_q4 = 0
        self._left_hold_ms = 0  # until that falls
        self._right_hold_ms = 0
        self._rest_ms = 0  # nothing put out in either axis
        self._wrong_ms = 0
        self._sign = 0
        self.wiper_debt = 0
        self.configure(settings)

    # Not in the tick. Any profile may be selected on the chair's own knob; a quarter above its rate
    # for a fresh battery and an even floor.
    def configure(self, settings):
        """As there."""
        fastest = 0
        for profile in range(len(PROFILES)):
            for name in ("left_q4_dps", "right_q4_dps"):
                row = profile_row(profile, name)
                fastest = max(fastest, getattr(settings, row), TABLE[index_of(row)][1])
        self._full_q4 = fastest * 5 // 4
        self._fall_q4 = self._full_q4 * 10 // limits.OBEY_FALL_MS

    # After the motion's tick; `i` is an Inputs, the outputs are those of this tick. True: it
    # disobeys.
    def step(self, i, linear_permille, turn_permille, armed):
        """As there."""
        if self._wait == 0:
            if i.heading_count != self._count:
                self._count = i.heading_count
                self._wait = 5
            return False
        self._wait -= 1
        if self._wait:
            return False
        if not armed:
            # Nothing reaches the chair: whoever turns it does so by hand.
            self._left_q4 = 0
            self._right_q4 = 0
            self._rest_ms = 0
            self._wrong_ms = 0
            return False
        self._allow(turn_permille)
        if linear_permille or turn_permille:
            self._rest_ms = 0
        elif self._rest_ms < limits.OBEY_COAST_MS:
            self._rest_ms += 10
        if i.heading_faults:
            self._wrong_ms = 0
            return False
        return self._judge(i.rate_q4)

    # How fast the chair may be turning in each sense: as the output asks for, and for a while as
    # one before did.
    def _allow(self, turn_permille):
        asked_q4 = turn_permille * self._full_q4 // 1000
        if asked_q4 > 0 and asked_q4 >= self._left_q4:
            self._left_q4 = asked_q4
            self._left_hold_ms = limits.OBEY_HOLD_MS
        elif self._left_hold_ms > 0:
            self._left_hold_ms -= 10
        else:
            self._left_q4 = max(0, asked_q4, self._left_q4 - self._fall_q4)
        asked_q4 = -asked_q4
        if asked_q4 > 0 and asked_q4 >= self._right_q4:
            self._right_q4 = asked_q4
            self._right_hold_ms = limits.OBEY_HOLD_MS
        elif self._right_hold_ms > 0:
            self._right_hold_ms -= 10
        else:
            self._right_q4 = max(0, asked_q4, self._right_q4 - self._fall_q4)

    def _judge(self, rate_q4):
        sign = 1
        most_q4 = self._left_q4
        if rate_q4 < 0:
            sign = -1
            rate_q4 = -rate_q4
            most_q4 = self._right_q4
        if self._rest_ms >= limits.OBEY_COAST_MS:
            most_q4 += limits.OBEY_STANDING_Q4_DPS
        else:
            most_q4 += limits.OBEY_MOVING_Q4_DPS
        if rate_q4 <= most_q4:
            self._wrong_ms = 0
            return False
        if sign != self._sign:
            self._sign = sign
            self._wrong_ms = 0
        self._wrong_ms += 10
        if self._wrong_ms < limits.OBEY_MS:
            return False
        self._wrong_ms = 0
        return True

    # After each write that was not verified, and while there is a debt. True: two writes of three
    # have failed for a second, though never three in a row.
    def wipers_written(self, verified):
        """As there."""
        if verified:
            self.wiper_debt = max(0, self.wiper_debt - 3)
            return False
        self.wiper_debt += 2
        if self.wiper_debt < limits.WIPER_DEBT:
            return False
        self.wiper_debt = 0
        return True


class PlainProfileCheck:
    """As ProfileCheck."""

    # model: the ChairModel of the selected profile, stepped by the motion.

    def __init__(self, model):
        """As there."""
        self._model = model
        self._count = -1
        self._wait = 0
        self._model_q10 = 0  # its rate at the sample
        self._steady_ms = 0
        self._agrees_ms = 0
        self._contradicts_ms = 0
        self._left_ms = 0  # until trust lapses for want of a turn that confirms it
        self._stood_ms = 0
        self._stuck_ms = 0
        self.agreed = False
        # The chair stands in spite of what would turn a quick one: turns may be given what the
        # selected profile needs to start.
        self.sluggish = False

    # After the motion's tick; `i` is an Inputs, the outputs are those of this tick.
    def step(self, i, linear_permille, turn_permille):
        """As there."""
        if self.agreed or self.sluggish:
            self._lapse(linear_permille, turn_permille)
        wait = self._wait
        if wait == 0:
            if i.heading_count != self._count:
                self._count = i.heading_count
                self._wait = 4
            return
        self._wait = wait - 1
        if wait == 4:
            self._model_q10 = self._model.seen_rate()
        if wait > 1:
            return
        model = self._model
        if model.steady() and abs(turn_permille) >= limits.TELLING_PERMILLE:
            self._steady_ms = min(self._steady_ms + 10, 1000)
        else:
            self._steady_ms = 0
            self._agrees_ms = 0
        tries = not -limits.TRYING_PERMILLE < turn_permille < limits.TRYING_PERMILLE
        if not tries or self.sluggish or not -24 < i.rate_q4 < 24 or i.heading_faults:
            self._stuck_ms = 0
        else:
            self._stuck_ms += 10
            if self._stuck_ms >= limits.TRYING_MS:
                self.sluggish = True
                self._left_ms = limits.TRUST_MS
                self._stood_ms = 0
        if i.heading_faults:
            return
        rate_q10 = self._model_q10
        seen_q10 = i.rate_q4 << 6
        if rate_q10 < 0:
            rate_q10 = -rate_q10
            seen_q10 = -seen_q10
        if abs(seen_q10) > rate_q10 + (rate_q10 >> 1) + 8192:
            self._contradict()
        elif rate_q10 > 6144 and self._steady_ms > model.dead_ms:
            if abs(seen_q10 - rate_q10) <= rate_q10 >> 2:
                self._contradicts_ms = 0
                self._agrees_ms += 10
                if self._agrees_ms >= 300:
                    self._agrees_ms = 0
                    self._left_ms = limits.TRUST_MS
                    self._stood_ms = 0
                    self.agreed = True
            else:
                self._contradict()

    # Counted in ticks: it lapses also while no heading comes.
    def _lapse(self, linear_permille, turn_permille):
        standing = limits.STANDING_PERMILLE
        if -standing < linear_permille < standing and -standing < turn_permille < standing:
            self._stood_ms += 1
        else:
            self._stood_ms = 0
        self._left_ms -= 1
        if self._left_ms <= 0 or self._stood_ms >= limits.TRUST_STANDING_MS:
            self.agreed = False
            self.sluggish = False
            self._agrees_ms = 0

    def _contradict(self):
        self._agrees_ms = 0
        self._contradicts_ms = min(self._contradicts_ms + 10, 200)
        if self._contradicts_ms >= 200:
            self.agreed = False
            self.sluggish = False


def plain_drive_both(settings, cap, linear, turn, caps, arcs):
    """As Motion._drive_both: what it puts out, linear and turn."""
    linear = _clamped(linear, min(cap, settings.linear_permille))
    turn = _clamped(turn, min(cap, settings.turn_permille))
    most_linear = caps[0 if linear > 0 else 1]
    most_turn = caps[2 if turn > 0 else 3]
    if arcs is not None:
        most_linear = min(most_linear, arcs.linear_cap)
        most_turn = min(most_turn, arcs.turn_cap)
    size = abs(linear)
    if size > most_linear:
        turn = _share(turn, most_linear, size)
        linear = _clamped(linear, most_linear)
    size = abs(turn)
    if size > most_turn:
        linear = _share(linear, most_turn, size)
        turn = _clamped(turn, most_turn)
    return linear, turn


# value * part // whole, towards 0.
def _share(value, part, whole):
    return value * part // whole if value >= 0 else -(-value * part // whole)


def _clamped(value, limit):
    return max(-limit, min(limit, value))
