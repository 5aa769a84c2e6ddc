# The speed's upper bound: above a chair of dead time, ramp and lag whatever it is told, and back to
# nothing within a stated time.

from gazeboard.core.speed import SpeedBound

PERIOD_MS = 8


class Chair:
    # What the bound is told of a chair: speeds in units/s at full deflection, as Stopping has them.

    def __init__(self, full=1000, dead_ms=24, tail_ms=92, brake=1000):
        self.full = full
        self.dead_ms = dead_ms
        self.tail_ms = tail_ms
        self.brake = brake


class Model:
    # That chair itself, in floats, a step a millisecond; it never accelerates slower than at once.

    def __init__(self, chair):
        self.chair = chair
        self.ramp = 0.0
        self.speed = 0.0
        self.pending = [0] * chair.dead_ms

    def step(self, permille):
        self.pending.append(permille)
        wanted = self.pending.pop(0) * self.chair.full / 1000
        self.ramp = max(wanted, self.ramp - self.chair.brake / 1000)
        self.speed += (self.ramp - self.speed) * (1 - 2.718281828 ** (-1 / self.chair.tail_ms))


class Dice:
    # Numbers that look random, the same on every machine.

    def __init__(self, seed):
        self._state = seed

    def below(self, n):
        self._state = (self._state * 75 + 74) % 65537
        return self._state % n


def run(bound, chair, permille, turns):
    return [bound.update(chair, permille) for _ in range(turns)]


def test_it_rises_at_once_to_what_the_output_may_cause():
    chair = Chair(full=556)
    assert SpeedBound(PERIOD_MS).update(chair, 1000) == 556
    assert SpeedBound(PERIOD_MS).update(chair, 500) == 278
    assert SpeedBound(PERIOD_MS).update(chair, 499) == 278  # rounded up
    assert SpeedBound(PERIOD_MS).update(chair, 1) == 1
    assert SpeedBound(PERIOD_MS).update(chair, 0) == 0
    assert SpeedBound(PERIOD_MS).update(Chair(full=1001), 1) == 2


def test_it_falls_after_the_dead_time_with_the_brake_behind_the_lag():
    chair = Chair()
    bound = SpeedBound(PERIOD_MS)
    assert run(bound, chair, 1000, 3) == [1000] * 3
    # Dead time 24 ms: three turns and what was left of the last one. Then 8 units a turn in the
    # ramp, which the bound follows by 8 parts in 100 of what it is above.
    fallen = run(bound, chair, 0, 12)
    assert fallen == [1000, 1000, 1000, 1000, 1000, 999, 997, 995, 992, 989, 985, 981]


def test_what_is_asked_within_the_dead_time_is_not_lost():
    chair = Chair(dead_ms=40)
    bound = SpeedBound(PERIOD_MS)
    bound.update(chair, 1000)
    bound.update(chair, 0)
    bound.update(chair, 600)  # a pulse on the way to the motors while the peak stands
    for _ in range(3000 // PERIOD_MS):
        now = bound.update(chair, 300)
        assert now >= 300
    assert now == 300
    bound.update(chair, 900)
    assert bound.update(chair, 300) == 900


def test_it_is_never_below_the_chair():
    for seed in range(1, 25):
        dice = Dice(seed)
        chair = Chair(
            100 + dice.below(1900),
            20 + dice.below(380),
            25 + dice.below(975),
            200 + dice.below(1800),
        )
        model = Model(chair)
        bound = SpeedBound(PERIOD_MS)
        permille = 0
        for _ in range(250):
            if dice.below(6) == 0:
                permille = (0, 0, dice.below(1001), 1000)[dice.below(4)]
            highest = 0
            for _ in range(PERIOD_MS):
                if dice.below(40) == 0:
                    permille = dice.below(1001)
                highest = max(highest, permille)
                model.step(permille)
            upper = bound.update(chair, highest)
            assert model.speed <= upper + 1, (seed, model.speed, upper)
            assert upper <= chair.full


def test_it_is_nothing_in_the_time_it_takes_to_stop():
    for chair in (Chair(), Chair(2000, 400, 1000, 200), Chair(100, 20, 25, 2000)):
        bound = SpeedBound(PERIOD_MS)
        run(bound, chair, 1000, 3)
        # Dead time, braking, then the lag: until 1 unit/s is left, and a slow end.
        stated_ms = chair.dead_ms + 1000 * chair.full // chair.brake + 9 * chair.tail_ms + 100
        ms = 0
        while bound.update(chair, 0):
            ms += PERIOD_MS
            assert ms <= stated_ms
        assert stated_ms // 4 < ms <= stated_ms, (ms, stated_ms)
        assert bound.update(chair, 0) == 0
        assert bound.update(chair, 1000) == chair.full  # and anew


def test_an_output_of_nothing_keeps_it_at_nothing():
    bound = SpeedBound(PERIOD_MS)
    assert run(bound, Chair(), 0, 20) == [0] * 20


def test_faster_numbers_count_at_once_and_slower_ones_do_not():
    slow = Chair(full=200)
    bound = SpeedBound(PERIOD_MS)
    run(bound, slow, 1000, 10)
    assert bound.update(Chair(full=900), 1000) == 900
    assert bound.update(slow, 1000) == 900


def test_a_repeated_peak_forgets_what_was_below_it():
    chair = Chair(dead_ms=80, tail_ms=0, brake=200000)
    plain = SpeedBound(PERIOD_MS)
    dented = SpeedBound(PERIOD_MS)
    for permille in (1000, 900, 1000):
        dented.update(chair, permille)
        plain.update(chair, 1000)
    assert run(dented, chair, 0, 100) == run(plain, chair, 0, 100)


def test_a_pulse_below_the_peak_counts_after_the_peak():
    chair = Chair(dead_ms=40, tail_ms=0, brake=200000)  # follows at once
    bound = SpeedBound(PERIOD_MS)
    assert run(bound, chair, 1000, 1) + run(bound, chair, 0, 9) == [1000] * 7 + [0] * 3
    seen = [bound.update(chair, permille) for permille in [1000, 600] + [300] * 15]
    # In turn 6 the chair does what it was told in turn 1; the bound is one turn behind.
    assert seen == [1000] * 7 + [600] * 6 + [300] * 4, seen


def test_the_dead_time_is_over_with_its_last_millisecond():
    chair = Chair(dead_ms=39, tail_ms=0, brake=200000)
    bound = SpeedBound(PERIOD_MS)
    assert run(bound, chair, 1000, 1) + run(bound, chair, 0, 9) == [1000] * 6 + [0] * 4


def test_the_brake_is_that_of_the_settings():
    chair = Chair(full=2400, dead_ms=24, tail_ms=0, brake=9600)  # 76.8 units in a turn
    bound = SpeedBound(PERIOD_MS)
    seen = run(bound, chair, 1000, 1) + run(bound, chair, 0, 30)
    begun = 5  # dead time, and the turn that the bound is behind
    for k in range(26):
        exact = 2400 - k * 76.8
        assert exact <= seen[begun - 1 + k] <= exact + 1 + k / 64, k


def test_the_end_of_the_lag_is_slow():
    chair = Chair(full=1, brake=100000)
    bound = SpeedBound(PERIOD_MS)
    seen = run(bound, chair, 1000, 1) + run(bound, chair, 0, 60)
    assert sum(seen) == 41, sum(seen)
