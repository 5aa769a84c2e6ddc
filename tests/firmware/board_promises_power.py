# Promises P1, P14 and P15 on the whole firmware in lockstep virtual time: power, resets, sessions.

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.core import limits
from gazelink import codes
from gazesim.board_rig import Rig
from promiserig import ENABLE_AT, armed, fault, stays_still_until_pressed_anew, toggles
from promises import CORE, kept, measured


def test_p1_neutral_before_the_first_tick():
    rig = Rig()
    assert rig.neutral()  # the pot's own power-on value is 128, which is not neutral
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == 0
    measured(CORE, "P1", "power-on: neutral, in ticks", rig.app.outbox.ticks, 0)


def test_p1_no_motion_and_no_enable_until_armed():
    rig = Rig()
    rig.press(codes.FORWARD)
    assert toggles(rig, 1500) == 0
    assert rig.neutral()
    assert rig.app.safety.override == codes.NOT_ARMED
    kept(CORE, "P1", "commands before the link is up")


def test_p1_a_reset_while_driving_comes_back_neutral_and_disarmed():
    rig = Rig()
    rig.drive()
    rig.boot()
    assert rig.neutral()
    assert toggles(rig, 500) == 0
    assert rig.app.safety.state == codes.DISARMED


def test_p14_a_new_session_disarms_and_needs_arming_and_a_new_press():
    rig = Rig()
    rig.drive()
    rig.keys.end()
    rig.say_hello(0x4321)
    rig.until(rig.neutral, 2)
    assert not armed(rig)
    rig.run(600)
    assert rig.neutral()
    stays_still_until_pressed_anew(rig)
    kept(CORE, "P14", "a new session disarms")


def test_p14_arming_is_refused_with_the_reason_while_something_is_commanded():
    rig = Rig()
    rig.run(1200)
    rig.press(codes.FORWARD)
    rig.run(100)
    rig.give(codes.ARM)
    rig.run(300)
    assert not armed(rig)
    assert rig.state["arm_reason"] == codes.COMMAND_ACTIVE
    assert rig.neutral()


def test_p15_the_relay_opens_without_the_board_and_power_back_is_p1():
    rig = Rig()
    rig.drive()
    ms = 0
    while rig.relay_closed:  # no board: nothing toggles the line
        ms += 1
        rig.now_ms += 1
        rig._relay()
    measured(CORE, "P15", "power of the board pulled: relay open", ms, 20)
    rig.boot()
    assert rig.neutral()
    assert toggles(rig, 500) == 0


def test_a_relay_that_stays_open_or_closed_is_a_fault():
    rig = Rig()
    rig.relay_works = False
    rig.run(1200)
    rig.give(codes.ARM)
    rig.run(300)
    assert not armed(rig)
    assert rig.app.safety.faults & (1 << codes.RELAY_OPEN)
    rig = Rig()
    rig.drive()
    rig.relay_works = False  # opens while driving
    rig.until(lambda: fault(rig, codes.RELAY_OPEN), limits.RELAY_RELEASE_MS + 5)
    assert rig.neutral()
    rig = Rig()
    rig.run(1200)
    rig._relay = lambda: rig.drive_pin(pins.RELAY_FEEDBACK, 1)  # welded, or the wire broken
    rig.run(limits.RELAY_STUCK_MS + 5)
    assert fault(rig, codes.RELAY_STUCK)
    rig.give(codes.ARM)
    rig.run(200)
    assert not armed(rig)
