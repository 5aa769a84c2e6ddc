# P21's rule once more, in other words, against the firmware's: at each heading sample of random
# drives whose gyro lies at the limit or one above it, both trip or neither does.

from dice import Dice
from gazeboard.core import limits
from gazeboard.core.obedience import Obedience
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings

SAMPLE_MS = 10
AFTER_TICKS = 5  # a sample is judged so long after it came
REST_AT, FALL_AT = 4, 8  # where Obedience keeps them
FULL_Q4 = 910 * 5 // 4  # a quarter above the fastest row of all profiles
FALL_Q4 = FULL_Q4 * SAMPLE_MS // limits.OBEY_FALL_MS
OUTPUTS = (0, 0, 1000, -1000, 500, -500, 200, -200, 1, -1)


class Sense:
    # How fast the chair may be turning in one sense.

    def __init__(self):
        self.most = 0
        self.until = 0  # what was asked for counts in full so long, samples

    def hear(self, asked):
        if asked > 0 and asked >= self.most:
            self.most = asked
            self.until = limits.OBEY_HOLD_MS // SAMPLE_MS
        elif self.until:
            self.until -= 1
        else:
            self.most = max(asked, self.most - FALL_Q4, 0)


class Rule:
    def __init__(self):
        self.sense = 0
        self.forget()

    def forget(self):
        self.left = Sense()
        self.right = Sense()
        self.rest = 0
        self.wrong = 0

    def limit(self, rate):
        extra = limits.OBEY_MOVING_Q4_DPS
        if self.rest >= limits.OBEY_COAST_MS // SAMPLE_MS:
            extra = limits.OBEY_STANDING_Q4_DPS
        return (self.right if rate < 0 else self.left).most + extra

    def put_out(self, linear, turn):
        asked = abs(turn) * FULL_Q4 // 1000
        if turn < 0 and asked * 1000 != -turn * FULL_Q4:
            asked += 1
        self.left.hear(asked if turn > 0 else -asked)
        self.right.hear(asked if turn < 0 else -asked)
        self.rest = self.rest + 1 if linear == 0 and turn == 0 else 0

    def trips(self, rate, faulty):
        if faulty or abs(rate) <= self.limit(rate):
            self.wrong = 0
            return False
        sense = -1 if rate < 0 else 1
        if sense != self.sense:
            self.wrong = 0
        self.sense = sense
        self.wrong += 1
        if self.wrong * SAMPLE_MS < limits.OBEY_MS:
            return False
        self.wrong = 0
        return True


def test_what_is_tripped_is_what_the_rule_says():
    for seed in range(1, 9):
        dice = Dice(seed)
        often = 120 if seed & 1 else 1800  # how often the outputs change: a rest may be long
        rule = Rule()
        inputs = Inputs()
        inputs.heading_count = 65000  # wraps on the way
        watch = Obedience(Settings())
        watch._count = 65000
        tripped = 0
        linear = turn = 0
        sense = 1
        over = 0
        armed = True
        for _ in range(2500):
            what = dice.roll(often)
            if what < 3:
                turn = OUTPUTS[dice.roll(10)]
                linear = OUTPUTS[dice.roll(10)]
            elif what == 3:
                linear = turn = 0
            elif what < 5:
                sense = -sense
            elif what < 7:
                over = dice.roll(8) != 0
            faulty = dice.roll(400) == 0
            armed = dice.roll(500) != 0
            holds = (rule.left.until, rule.right.until)
            if armed:
                rule.put_out(linear, turn)
            else:
                rule.forget()
                rule.left.until, rule.right.until = holds  # of a rate that is none
            rate = sense * (rule.limit(sense) + over)
            inputs.heading_count = (inputs.heading_count + 1) & 0xFFFF
            inputs.rate_q4 = rate
            inputs.heading_faults = 4 if faulty else 0
            for _ in range(AFTER_TICKS):
                assert watch.step(inputs, linear, turn, armed) is False
            expected = armed and rule.trips(rate, faulty)
            assert watch.step(inputs, linear, turn, armed) is expected
            assert watch.step(inputs, linear, turn, armed) is False  # no sample, no judgement
            assert watch._words[REST_AT] <= limits.OBEY_COAST_MS
            tripped += expected
        assert tripped > 3


def test_two_writes_of_three_that_fail_add_up():
    watch = Obedience(Settings())
    for debt in range(2, limits.WIPER_DEBT, 2):
        assert watch.wipers_written(False) is False
        assert watch.wiper_debt == debt
    assert watch.wipers_written(False) is True
    assert watch.wiper_debt == 0
    watch.wipers_written(False)
    watch.wipers_written(False)
    assert watch.wipers_written(True) is False
    assert watch.wiper_debt == 1
    for debt in range(3, limits.WIPER_DEBT, 2):
        assert watch.wipers_written(False) is False
        assert watch.wiper_debt == debt
    assert watch.wipers_written(False) is True
    watch.wipers_written(False)
    watch.wipers_written(False)
    watch.wipers_written(True)
    assert watch.wipers_written(True) is False
    assert watch.wiper_debt == 0


def test_the_fastest_row_of_all_profiles_counts_and_a_faster_setting_more():
    settings = Settings()
    assert Obedience(settings)._full_q4 == FULL_Q4
    settings.p1_2_right_q4_dps = 2000
    assert Obedience(settings)._full_q4 == 2500
    for number in range(1, 6):
        for side in ("left", "right"):
            setattr(
                settings,
                "p%s_%s_q4_dps" % (("1_2", "2_1", "3_1", "4_1", "5_1")[number - 1], side),
                80,
            )
    assert Obedience(settings)._full_q4 == FULL_Q4  # never tamer than compiled in


def test_it_falls_from_full_to_nothing_within_its_time():
    for rate_q4, fall_q4 in ((1079, 8), (1080, 9), (2399, 19), (2400, 20)):
        settings = Settings()
        settings.p1_2_right_q4_dps = rate_q4
        assert Obedience(settings)._words[FALL_AT] == fall_q4


def test_no_allowance_of_before_a_disarming_counts():
    # Disarmed for a sample while a full turn is held: a rate above the limit is wrong at once.
    for sign in (1, -1):
        inputs = Inputs()
        watch = Obedience(Settings())

        def sample(rate, turn, armed):
            inputs.heading_count += 1
            inputs.rate_q4 = rate
            for _ in range(AFTER_TICKS + 1):
                trips = watch.step(inputs, 0, turn, armed)
            return trips

        for armed in (False, True, True, False):
            sample(0, sign * 1000, armed)
        samples = 1
        while not sample(sign * (limits.OBEY_MOVING_Q4_DPS + 1), 0, True):
            samples += 1
        assert samples * SAMPLE_MS == limits.OBEY_MS


def test_the_least_turn_to_the_left_is_held_like_any_other():
    inputs = Inputs()
    watch = Obedience(Settings())
    samples = 0
    trips = False
    while not trips:
        inputs.heading_count += 1
        inputs.rate_q4 = limits.OBEY_MOVING_Q4_DPS + 1
        for _ in range(AFTER_TICKS + 1):
            trips = watch.step(inputs, 0, 1 if samples == 0 else 0, True)
        samples += 1
    assert samples * SAMPLE_MS == limits.OBEY_HOLD_MS + limits.OBEY_MS + SAMPLE_MS


def test_what_a_turn_asks_for_is_rounded_to_the_right():
    # 73 permille of 1137 are 83.001.
    for turn, limit in ((73, 83), (-73, 84)):
        for over in (0, 1):
            inputs = Inputs()
            watch = Obedience(Settings())
            trips = 0
            for _ in range(60):
                inputs.heading_count += 1
                inputs.rate_q4 = (limit + limits.OBEY_MOVING_Q4_DPS + over) * (turn // 73)
                for _ in range(AFTER_TICKS + 1):
                    trips += watch.step(inputs, 0, turn, True)
            assert trips == over


def test_no_rest_of_before_a_disarming_counts():
    inputs = Inputs()
    watch = Obedience(Settings())
    trips = []
    for number in range(600):
        armed = number != 300
        inputs.heading_count += 1
        inputs.rate_q4 = 0 if number <= 300 else limits.OBEY_STANDING_Q4_DPS + 1
        for _ in range(AFTER_TICKS + 1):
            tripped = watch.step(inputs, 0, 0, armed)
        if tripped:
            trips.append((number - 300) * SAMPLE_MS)
    assert trips[0] == limits.OBEY_COAST_MS + limits.OBEY_MS - SAMPLE_MS
