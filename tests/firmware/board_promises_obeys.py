# Promise P21 and the faults beside it on the whole firmware: the chair turns otherwise than it is
# told, writes fail often but never three in a row, a contact moves that nobody fitted.

from gazeboard.boards import bank_layout as at
from gazeboard.core import limits
from gazelink import codes
from gazelink.settings_table import index_of
from gazesim.board_rig import POT, Rig
from promiserig import armed, ask, fault, toggles
from promises import CORE, measured

LIMIT_MS = limits.OBEYS_MS


def reset(rig):
    rig.give(codes.RESET_FAULTS, codes.DRIVER)
    rig.run(150)
    assert fault(rig, codes.DISOBEYS), "the caretaker clears"
    rig.give(codes.RESET_FAULTS, codes.CARETAKER)
    rig.run(150)


def test_p21_a_chair_that_turns_on_is_disarmed():
    for verb, rate_dps in ((codes.LEFT, 57.0), (codes.RIGHT, -17.0)):
        rig = Rig()
        rig.drive(verb)
        rig.rate_dps = rate_dps
        rig.run(500)
        rig.release()
        rig.until(rig.neutral, 60)
        ms = rig.until(lambda: fault(rig, codes.DISOBEYS), 4000)
        assert rig.neutral() and not armed(rig)
        measured(CORE, "P21", "turns on with neutral put out", ms, LIMIT_MS)
        assert toggles(rig, 50) == 0
        rig.run(2000)
        assert rig.state["first_fault"] == codes.FAULT_REASON + codes.DISOBEYS
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.DISOBEYS
        rig.rate_dps = 0.0
        rig.run(500)
        assert fault(rig, codes.DISOBEYS)  # latched
        reset(rig)
        rig.drive()


def test_p21_a_chair_that_turns_against_the_command_is_disarmed():
    rig = Rig()
    rig.drive(codes.LEFT)
    rig.rate_dps = -40.0
    ms = rig.until(lambda: fault(rig, codes.DISOBEYS), 4000)
    rig.until(rig.neutral, 0)
    measured(CORE, "P21", "turns against the command", ms, LIMIT_MS)
    assert not armed(rig)


def test_p21_pushed_by_hand_while_disarmed_is_nothing():
    rig = Rig()
    rig.run(1200)
    rig.rate_dps = 90.0
    rig.run(4000)
    assert rig.app.safety.faults == 0
    rig.rate_dps = 0.0
    rig.arm()


def test_p8_two_writes_of_three_that_fail_for_a_second_end_the_enable_line():
    rig = Rig()
    rig.drive()
    ms = 0
    while not fault(rig, codes.WIPER):
        rig.bank[POT + at.SLOT_NAK_COUNT] = 2  # two ticks, one transfer each
        rig.run(3)
        ms += 3
        assert ms < 2000
    measured(CORE, "P8", "two writes of three fail, never three in a row", ms, 1000)
    assert not armed(rig)
    assert toggles(rig, 50) == 0


def test_a_contact_that_moves_although_none_is_fitted_is_refused():
    rig = Rig()
    rig.run(1200)
    assert ask(rig, codes.SETTING_SET, index_of("relay_fitted"), 0)[1] == codes.NO_REASON
    for _ in range(2):
        rig.run(600)
        rig.give(codes.ARM)
        for _ in range(400):
            rig.one_ms()
            assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.RELAY_UNEXPECTED
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(150)
        assert rig.state["arm_reason"] == codes.NO_REASON  # it does not move now
    rig.relay_works = False  # there is none indeed
    ask(rig, codes.SETTING_SET, index_of("relay_fitted"), 0)
    rig.drive()
    # One that begins to move while armed, whatever it was at rest.
    rig.relay_works = True
    rig.until(lambda: fault(rig, codes.RELAY_UNEXPECTED), 60)
    rig.run(1)
    assert rig.neutral() and not armed(rig)
