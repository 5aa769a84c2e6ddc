# The order of a tick and what each part is told, with parts that say what the test wants and keep
# what they are told.

from gazeboard.core import limits
from gazeboard.core.tick import PERIOD_US, Tick
from gazelink import codes


class Parts:
    # Safety, motion, obstacles, obedience, profile check and clock in one.

    def __init__(self):
        self.told = []
        self.state = codes.ARMED
        self.permitted = True
        self.enable = True
        self.faults = 5
        self.blocked = 6
        self.caps = (1, 2, 3, 4)
        self.auto_caps = (5, 6, 7, 8)
        self.arcs = "arcs"
        self.linear_permille = 7
        self.turn_permille = 8
        self.ended = False
        self.end_reason = codes.TIME_LIMIT
        self.missed_ms = 0
        self.owes = False
        self.late = False
        self.passed_ms = 0
        self.disobeys = False
        self.often = False
        self.wiper_debt = 0
        self.agreed = "agreed"
        self.sluggish = "sluggish"
        self.breaks = False
        self.toggles = True

    def tell(self, *what):
        self.told.append(what)
        if self.breaks:
            raise ValueError(what[0])

    def trip(self, fault):
        self.tell("trip", fault)
        self.linear_permille = 9

    def finished(self, reason):
        self.tell("finished", reason)

    def stop(self):
        self.tell("stop")
        self.linear_permille = self.turn_permille = 0

    def missed(self, ms):
        self.tell("missed", ms)

    def tick_raised(self):
        self.tell("raised")


class Part:
    # One of them: its step is told under its name.
    def __init__(self, parts, name):
        object.__setattr__(self, "_parts", parts)
        object.__setattr__(self, "_name", name)

    def __getattr__(self, name):
        return getattr(self._parts, name)

    def __setattr__(self, name, value):
        setattr(self._parts, name, value)

    def step(self, *what):
        self._parts.tell(self._name, *what)
        if self._name == "motion":
            self._parts.linear_permille = 70
            self._parts.turn_permille = 80
        if self._name == "clock":
            return self._parts.passed_ms
        return self._name == "obedience" and self._parts.disobeys

    def auto_blocked(self, *what):
        self._parts.tell("auto", *what)
        return 11

    def wipers_written(self, *what):
        self._parts.tell(self._name + " written", *what)
        if self._name == "obedience":
            return self._parts.often
        return self._parts.toggles


class Asked:
    # The inputs, of which the tick itself reads the mode only.
    def __init__(self):
        self.mode = codes.CONTINUOUS


INPUTS = Asked()
NAMES = ("safety", "motion", "obstacles", "obedience", "profile_check", "clock")


def made():
    parts = Parts()
    return parts, Tick(*[Part(parts, name) for name in NAMES])


def decided(tick, elapsed_us=PERIOD_US):
    tick.decide(INPUTS, elapsed_us, "closed", "open", "pressed")


def test_before_the_first_tick_nothing_is_put_out():
    _, tick = made()
    assert (tick.linear_permille, tick.turn_permille) == (0, 0)
    assert (tick.enable_level, tick.missed_ms, tick.late) == (0, 0, False)
    assert PERIOD_US == 1000


def test_each_part_is_called_in_its_order_with_its_values():
    for armed in (True, False):
        parts, tick = made()
        parts.state = codes.ARMED if armed else codes.ARMING
        decided(tick)
        assert parts.told == [
            ("obstacles", INPUTS, 7, 8, armed, "agreed", "sluggish"),
            ("safety", INPUTS, 6, "closed", "open", "pressed", False),
            ("motion", INPUTS, 6, (1, 2, 3, 4), 5, "arcs", 0),
            ("profile_check", INPUTS, 70, 80),
            ("obedience", INPUTS, 70, 80, armed),
        ]
        assert (tick.linear_permille, tick.turn_permille) == (70, 80)
        assert (tick.missed_ms, tick.late) == (0, False)
    parts.state = codes.DISARMED
    parts.told = []
    decided(tick)
    assert parts.told[0][4] is False
    assert parts.told[-1][4] is False


def test_an_auto_motion_has_blocks_and_caps_of_its_own():
    for mode in range(len(codes.MODES)):
        for state in range(len(codes.STATES)):
            parts, tick = made()
            parts.state = state
            INPUTS.mode = mode
            decided(tick)
            INPUTS.mode = codes.CONTINUOUS
            is_auto = mode == codes.AUTO and state == codes.ARMED
            told = parts.told[1:-2]
            assert told[:-2] == ([("auto", INPUTS)] if is_auto else [])
            assert told[-2][2] == (11 if is_auto else 6)
            assert told[-1][3] == ((5, 6, 7, 8) if is_auto else (1, 2, 3, 4))


def test_without_permission_motion_stops():
    parts, tick = made()
    parts.permitted = False
    decided(tick)
    assert [what[0] for what in parts.told[:3]] == ["obstacles", "safety", "stop"]
    assert (tick.linear_permille, tick.turn_permille) == (0, 0)


def test_a_motion_that_has_ended_is_reported_to_safety():
    parts, tick = made()
    parts.ended = True
    decided(tick)
    assert parts.told[3] == ("finished", codes.TIME_LIMIT)


def test_a_chair_that_disobeys_is_tripped_and_put_out_nothing():
    parts, tick = made()
    parts.disobeys = True
    decided(tick)
    assert parts.told[-2:] == [("trip", codes.DISOBEYS), ("stop",)]
    assert (tick.linear_permille, tick.turn_permille) == (0, 0)


def test_the_clock_is_asked_when_a_tick_is_late_or_time_is_owed():
    on_time = limits.TICK_ON_TIME_US
    for elapsed_us, owes, asked in (
        (PERIOD_US, False, False),
        (PERIOD_US, True, True),
        (0, False, False),
        (-1, False, True),
        (on_time, False, False),
        (on_time + 1, False, True),
        (on_time + 1, True, True),
    ):
        parts, tick = made()
        parts.owes = owes
        parts.passed_ms = 3
        decided(tick, elapsed_us)
        assert (("clock", elapsed_us) in parts.told) is asked
        assert (("missed", 3) in parts.told) is asked
        assert parts.missed_ms == tick.missed_ms == (3 if asked else 0)
        assert [what[-1] for what in parts.told if what[0] == "motion"] == [tick.missed_ms]
        # Less than a millisecond is no time missed.
        parts.passed_ms = 0
        parts.told = []
        parts.missed_ms = 4
        decided(tick, elapsed_us)
        assert parts.missed_ms == 4
        assert tick.missed_ms == 0
        assert "missed" not in [what[0] for what in parts.told]


def test_a_late_tick_is_reported_to_safety():
    parts, tick = made()
    parts.late = True
    decided(tick)
    assert tick.late is True
    assert parts.told[1][-1] is True


def test_the_enable_line_is_toggled_while_safety_permits_it():
    parts, tick = made()
    levels = [tick.written(True, "neutral") for _ in range(4)]
    assert levels == [1, 0, 1, 0]
    assert parts.told == [("safety written", True, "neutral")] * 4
    tick.written(True, False)
    # Not verified: it stays as it is. Not enabled: it falls.
    parts.toggles = False
    assert [tick.written(True, False) for _ in range(3)] == [1, 1, 1]
    assert tick.enable_level == 1
    parts.enable = False
    assert tick.written(True, False) == 0
    assert tick.enable_level == 0


def test_writes_are_counted_when_they_fail_and_while_there_is_a_debt():
    for verified, debt, often, told in (
        (True, 0, True, []),
        (True, 2, False, [("obedience written", True)]),
        (False, 0, False, [("obedience written", False)]),
        (False, 2, False, [("obedience written", False)]),
        (False, 0, True, [("obedience written", False), ("trip", codes.WIPER)]),
        (True, 2, True, [("obedience written", True), ("trip", codes.WIPER)]),
    ):
        parts, tick = made()
        parts.wiper_debt = debt
        parts.often = often
        tick.written(verified, "neutral")
        assert parts.told == told + [("safety written", verified, "neutral")]


def test_an_exception_leaves_nothing_on_whatever_else_is_broken():
    for breaks in (False, True):
        parts, tick = made()
        tick.enable_level = 1
        parts.breaks = breaks
        tick.raised()
        assert tick.enable_level == 0
        assert parts.told == [("raised",), ("stop",)]
