# The firmware's parts one by one: angles, heading, joystick, settings, shared data.

from gazeboard.boards import bank_layout as at
from gazeboard.boards.bank_devices import BankI2C
from gazeboard.core import limits
from gazeboard.core.angle import wrapped
from gazeboard.core.shared import Inbox, Inputs
from gazeboard.io.heading import HeadingMonitor
from gazeboard.io.joystick import Joystick, counts
from gazeboard.io.settings import Settings
from gazeboard.io.storage import sealed
from gazelink import codes
from gazelink.settings_table import NAMES, TABLE, index_of
from gazesim.board_rig import POT, REGS

# -- angles ----------------------------------------------------------------------------------------


def test_wrapped_is_the_shorter_way():
    assert wrapped(0) == 0
    assert wrapped(5759) == -1
    assert wrapped(2879) == 2879
    assert wrapped(2881) == -2879
    assert wrapped(-160) == -160


# -- heading ---------------------------------------------------------------------------------------


def test_a_healthy_turn_raises_nothing():
    monitor = HeadingMonitor()
    heading = 0.0
    for k in range(3000):
        rate = 60 if k % 400 < 200 else -60
        heading += rate * 16 / 100
        monitor.feed(int(heading) % 5760, rate * 16, False, 10, True)
        assert monitor.faults == 0
        assert abs(wrapped(monitor.heading_q4 - int(heading))) < 2


def test_a_gyro_scale_error_of_three_percent_is_no_fault():
    monitor = HeadingMonitor()
    heading = 0.0
    for _ in range(3000):
        heading += 90 * 16 / 100
        monitor.feed(int(heading) % 5760, int(90 * 16 * 1.03), False, 10, True)
    assert monitor.faults == 0


def test_a_heading_that_reads_30_for_90_is_found():
    monitor = HeadingMonitor()
    heading = 0.0
    for _ in range(100):
        heading += 20 * 16 / 100  # the heading says 20 degrees/s, the gyro 60
        monitor.feed(int(heading) % 5760, 60 * 16, False, 10, True)
    assert monitor.faults & (1 << codes.HEADING_JUMP)


def test_faults_clear_after_half_a_second_of_good_samples():
    monitor = HeadingMonitor()
    monitor.feed(0, 0, False, 10, False)
    for _ in range(12):
        monitor.feed(0, 0, True, 10, False)
    assert monitor.faults == 1 << codes.HEADING_FROZEN
    for k in range(60):
        monitor.feed(k & 1, 0, False, 10, False)
        if k < 45:
            assert monitor.faults
    assert monitor.faults == 0


def samples_until_trusted(read_twice):
    # After a frozen heading; read_twice(k): sample k is the one before it. None: never.
    monitor = HeadingMonitor()
    monitor.feed(0, 0, False, 10, False)
    for _ in range(12):
        monitor.feed(0, 0, True, 10, False)
    assert monitor.faults == 1 << codes.HEADING_FROZEN
    heading = 0
    fresh = 0
    for k in range(400):
        same = read_twice(k)
        heading ^= not same
        fresh += not same
        monitor.feed(heading, 0, same, 10, False)
        if not monitor.faults:
            return fresh
    return None


def test_samples_read_twice_do_not_keep_a_fault_and_do_not_count_as_good():
    # Sensor and board have clocks of their own; at some phases of them one sample is read twice,
    # another never. A simulator on a PC can stay at such a phase for minutes.
    for every in range(2, 60):
        assert samples_until_trusted(lambda k: k % every == 1) == 50, every
    assert samples_until_trusted(lambda k: k % 4 != 3) == 50
    # Standing still for longer than it may while armed:
    assert samples_until_trusted(lambda k: k % 5 != 4) is None


def test_a_fault_that_the_reads_found_clears_after_as_long():
    for bit in (codes.HEADING_BUS, codes.HEADING_RESET):
        monitor = HeadingMonitor()
        for k in range(200):
            monitor.feed(k & 1, 0, False, 10, True)
        monitor.fault(1 << bit)
        for k in range(50):
            assert monitor.faults == 1 << bit
            monitor.feed(k & 1, 0, False, 10, True)
        assert monitor.faults == 0


# -- joystick --------------------------------------------------------------------------------------


def test_counts_never_leave_the_chairs_window():
    for neutral in (150, 170, 190):
        before = 0
        for permille in range(-1000, 1001):
            value = counts(permille, neutral)
            assert 85 <= value <= 254
            assert value >= before
            before = value
        assert counts(0, neutral) == neutral


def test_writes_and_verifies_both_wipers():
    bank = bytearray(at.SLOTS_AT + 128 * at.SLOT_SIZE)
    bank[POT + at.SLOT_PRESENT] = 1
    bank[POT + at.SLOT_STYLE] = at.STYLE_AD5282
    joystick = Joystick(BankI2C(bank, 0))
    joystick.set_neutral(170, 168)
    assert joystick.write(0, 0)
    assert joystick.neutral
    assert (bank[POT + REGS], bank[POT + REGS + 1]) == (170, 168)
    assert joystick.write(1000, -1000)
    assert not joystick.neutral
    assert (bank[POT + REGS], bank[POT + REGS + 1]) == (254, 85)
    bank[POT + at.SLOT_NAK_COUNT] = 1
    assert not joystick.write(0, 0)
    assert joystick.write(0, 0)


# -- settings --------------------------------------------------------------------------------------


def test_defaults_and_limits_keep_the_promises():
    for name, default, low, high in TABLE:
        assert low <= default <= high, name
    rows = {row[0]: row for row in TABLE}
    for name in ("neutral_linear_count", "neutral_turn_count"):
        assert rows[name][1] == limits.WIPER_NEUTRAL
        assert limits.WIPER_MIN < rows[name][2]
        assert rows[name][3] < limits.WIPER_MAX
    assert rows["step_forward_ms"][3] == limits.STEP_FORWARD_MAX_MS
    assert rows["step_turn_limit_ms"][3] == limits.STEP_TURN_MAX_MS
    assert rows["supervision_ms"][3] == limits.SUPERVISION_MAX_MS
    assert rows["auto_mm_s"][3] == limits.AUTO_MM_S
    assert rows["auto_limit_s"][3] == limits.AUTO_LIMIT_MAX_S


def test_settings_survive_being_sealed():
    s = Settings()
    assert s.set(index_of("linear_permille"), 300) == codes.NO_REASON
    again = Settings(s.text())
    assert again.calibrated
    for name in NAMES:
        assert getattr(again, name) == getattr(s, name)
    assert again.linear_permille == 300


def test_a_value_out_of_range_is_refused_and_changes_nothing():
    s = Settings()
    for index in range(len(TABLE)):
        name, default, low, high = TABLE[index]
        change = s.set_neutral if name.startswith("neutral_") else s.set
        for value in (low - 1, high + 1, 65535):
            assert change(index, value) == codes.SETTING_OUT_OF_RANGE
            assert s.get(index) == default
        assert change(index, high) == codes.NO_REASON
        assert change(index, low) == codes.NO_REASON
    assert s.set(len(TABLE), 1) == codes.SETTING_UNKNOWN


def test_damaged_or_foreign_settings_are_refused_whole():
    good = Settings().text()
    for text, reason in (
        (good[:-3], "CRC"),
        (good.replace("600", "601"), "CRC"),
        ('{"linear_permille": 300}', "CRC"),
        ("", "CRC"),
        (sealed("[1]"), "not a JSON object"),
        (sealed('{"linear_permille": 300, "speed": 1}'), "unknown name speed"),
        (sealed('{"turn_permille": 250, "linear_permille": 1001}'), "whole number 50..1000"),
        (sealed('{"linear_permille": 30.5}'), "whole number"),
        (sealed('{"linear_permille": "fast"}'), "whole number"),
        (sealed('{"linear_permille": true}'), "whole number"),
    ):
        s = Settings(text)
        assert not s.calibrated
        assert reason in s.error, s.error
        assert (s.linear_permille, s.turn_permille) == (600, 500)


# -- shared data -----------------------------------------------------------------------------------


def test_inputs_copy_every_field():
    a = Inputs()
    b = Inputs()
    for k in range(len(Inputs.FIELDS)):
        setattr(a, Inputs.FIELDS[k], k + 1)
    b.copy_from(a)
    for k in range(len(Inputs.FIELDS)):
        assert getattr(b, Inputs.FIELDS[k]) == k + 1


def test_publish_is_one_swap_and_beat_reaches_both():
    inbox = Inbox()
    front = inbox.front
    inbox.back.verb = codes.LEFT
    inbox.publish()
    assert inbox.front is front  # nothing touched: nothing copied
    inbox.touch()
    inbox.publish()
    assert inbox.front is not front
    assert inbox.front.verb == codes.LEFT
    assert inbox.back.verb == codes.LEFT
    inbox.beat()
    assert inbox.front.service_count == inbox.back.service_count == 1
