# Any gyro value with any legal settings: the tick stays within its tables and within the integers
# that need no memory. On 32-bit MicroPython with the heap locked, as in the timer's interrupt.

from boardtest import HAS_NATIVE, ON_MICROPYTHON
from gazeboard.boards.bank_layout import SLOT_NAK_COUNT
from gazeboard.core import limits
from gazeboard.io.settings import Settings
from gazeboard.turning.chair_model import ChairModel
from gazeboard.turning.turn import turn_controller
from gazelink import codes
from gazelink.settings_table import TABLE
from gazesim.board_rig import IMU, Rig
from promiserig import fault

if ON_MICROPYTHON:
    import micropython

_NEUTRAL = ("neutral_linear_count", "neutral_turn_count")


class Rows:
    # Settings with every row at its lowest or highest; `but` has the opposite end.
    def __init__(self, high, but=()):
        self.high = high
        self.but = but

    def put(self, settings):
        for name, _default, low, high in TABLE:
            if name in _NEUTRAL or name == "relay_fitted":
                continue
            top = self.high
            for part in self.but:
                if part in name:
                    top = not top
            setattr(settings, name, high if top else low)
        settings.profile = 4


VARIANTS = (
    Rows(True),
    Rows(False),
    Rows(True, ("left_q4_dps",)),
    Rows(True, ("right_q4_dps",)),
    Rows(False, ("left_q4_dps",)),
    Rows(False, ("right_q4_dps",)),
    Rows(True, ("dead_time_ms", "lag_ms", "deadband")),
    Rows(False, ("q4_dps", "dps2")),
)


def locked(rig):
    tick = rig.app.tick

    def ticked(_app):
        if HAS_NATIVE:
            micropython.heap_lock()
        try:
            tick()
        finally:
            if HAS_NATIVE:
                micropython.heap_unlock()

    rig.board.tick = ticked


def rates():
    for raw in (-32768, -32767, -17905, -17904, -1, 0, 1, 17904, 17905, 32766, 32767):
        yield raw
    raw = -32768
    while raw < 32768:
        yield raw
        raw += 977


def test_no_gyro_value_costs_memory_in_any_motion():
    for rows in VARIANTS:
        for lidar in (True, False):
            rig = Rig()
            rig.app.settings.calibrated = True
            rows.put(rig.app.settings)
            rig.app._apply_settings()
            locked(rig)
            rig.run(1200)
            rig.give(codes.ARM)
            rig.run(200)
            rig.lidar_alive = lidar
            if not lidar:
                rig.app.obstacles._age_ms = limits.AGE_MAX_MS
            verbs = (codes.LEFT, codes.RIGHT, codes.DRIVE, codes.FORWARD)
            k = 0
            for raw in rates():
                rig.rate_dps = raw / 16
                if k % 8 == 0:
                    mode = codes.STEP if k % 16 else codes.CONTINUOUS
                    rig.press(verbs[k // 8 % 4], mode, 300, -300)
                k += 1
                rig.run(11)
                assert not fault(rig, codes.TICK_EXCEPTION), (raw, rows.high, rows.but, lidar)


def test_every_gyro_value_reaches_the_tick_within_what_products_can_bear():
    # The longest age times the greatest rate, and its square, stay small integers.
    rate = limits.RATE_MAX_Q4_DPS
    assert rate * limits.AGE_MAX_MS < 1 << 30
    assert rate * rate < 1 << 30
    rig = Rig()
    rig.run(700)
    for raw in rates():
        rig.rate_dps = raw / 16
        rig.run(21)
        assert rig.app.inbox.front.rate_q4 == max(-rate, min(rate, raw))


def test_the_wrap_of_the_ticks_costs_no_memory():
    for missed_us in (0, 5000):
        rig = Rig()
        rig.drive()
        locked(rig)
        rig.app.outbox.ticks = (1 << 30) - 100
        rig.app.telemetry._due = (1 << 30) - 100
        rig.run(98)
        rig.clock.now_us += missed_us
        rig.run(102)
        assert not fault(rig, codes.TICK_EXCEPTION)
        assert rig.app.outbox.ticks == 100 + missed_us // 1000


# As the Teensy's, which takes what it is given for small integers.
def strict(ticks_diff):
    def diff(a, b):
        assert 0 <= a < 1 << 30, a
        assert 0 <= b < 1 << 30, b
        return ticks_diff(a, b)

    return diff


def test_the_heading_sensors_times_wrap_with_the_clock():
    for before_ms in (3, 25, 30, 150, 400, 405, 408):  # while it starts, and reads
        for loses in (False, True):
            rig = Rig()
            rig.board._ms = (1 << 30) - before_ms
            rig.app._imu._ticks_diff = strict(rig.board.ticks_diff)
            for ms in range(before_ms + 100):
                if loses and ms in (100, before_ms - 2, before_ms + 5):
                    rig.bank[IMU + SLOT_NAK_COUNT] = 1
                rig.one_ms()
            rig.bank[IMU + SLOT_NAK_COUNT] = 0
            rig.run(1500)
            assert rig.board.ticks_ms() < 2000
            samples = rig.app._imu.samples
            rig.run(200)
            assert rig.app._imu.samples == samples + 20
            assert rig.app._imu.faults == 0


class Watched(list):
    # A plan's words, that note which of them are read.
    def __init__(self, words):
        super().__init__(words)
        self.read = set()

    def __getitem__(self, at):
        self.read.add(at)
        return list.__getitem__(self, at)


def test_stop_plans_read_their_own_table_however_uneven_the_sides_are():
    if ON_MICROPYTHON:
        return  # viper reads memory, and const() leaves no name: watched where lists are read
    from gazeboard.turning.stop_plan import _CELLS, _COUNTER, _DECAY

    speeds = (80, 81, 273, 364, 910, 1700, 2400)
    for left in speeds:
        for right in speeds:
            settings = Settings()
            settings.p3_1_left_q4_dps = left
            settings.p3_1_right_q4_dps = right
            settings.p3_1_accelerate_dps2 = 600
            settings.p3_1_brake_dps2 = 600
            turn = turn_controller(settings)
            for out in (1000, -1000):
                model = ChairModel(settings)
                for _ in range(900):
                    model.step(out)
                for side, plan in ((1, turn._left), (-1, turn._right)):
                    words = Watched(plan._words)
                    plan._words = words
                    for _ in range(40):
                        plan.counters(model.state, side)
                        assert max(words.read, default=0) < _DECAY + _CELLS, (left, right, side)
                        model.step(0)
                    words.read.clear()
                    for _ in range(900):
                        model.step(out)
                        plan.ahead_q8(model.state, 0, side, 1)
                    for at in words.read:
                        assert at < _DECAY + _CELLS or _COUNTER <= at < _COUNTER + _CELLS
