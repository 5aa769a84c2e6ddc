# The joystick's neutral: changed by its own request only, in force for driving once it is saved.

from gazelink import codes
from gazelink.settings_table import index_of
from gazesim.board_rig import SESSION, Rig
from promiserig import ask

LINEAR = index_of("neutral_linear_count")
TURN = index_of("neutral_turn_count")
PLAIN = index_of("creep_mm_s")
PROFILE = index_of("profile")
UNCALIBRATED = codes.FAULT_REASON + codes.CALIBRATION


def connected():
    rig = Rig()
    rig.run(1200)
    return rig


def reason(rig):
    rig.run(30)
    return rig.state["arm_reason"]


# As its calibration does at the end.
def measured(rig, linear, turn):
    assert ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, linear) == (linear, codes.NO_REASON)
    assert ask(rig, codes.SETTING_SET_NEUTRAL, TURN, turn) == (turn, codes.NO_REASON)


def test_plain_set_and_defaults_leave_the_neutral_alone():
    rig = connected()
    for index in (LINEAR, TURN):
        for value in (170, 171, 190):
            answer = ask(rig, codes.SETTING_SET, index, value)
            assert answer == (170, codes.SETTING_BY_CALIBRATION)
    assert rig.neutral()
    assert ask(rig, codes.SETTING_SET_NEUTRAL, PLAIN, 150) == (120, codes.SETTING_UNKNOWN)
    assert ask(rig, codes.SETTING_SET_NEUTRAL, 250, 150) == (0, codes.SETTING_UNKNOWN)
    for value in (149, 191, 0, 65535):
        answer = ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, value)
        assert answer == (170, codes.SETTING_OUT_OF_RANGE)
    rig.arm()


def test_a_changed_neutral_does_not_arm_until_it_is_saved_and_proven_anew():
    rig = connected()
    assert reason(rig) == codes.NO_REASON
    assert ask(rig, codes.SETTING_SET_NEUTRAL, TURN, 174) == (174, codes.NO_REASON)
    rig.run(2)
    assert rig.wipers() == (170, 174)  # for the meter
    rig.give(codes.ARM)
    for _ in range(800):
        rig.one_ms()
        assert rig.app.safety.state == codes.DISARMED
    assert reason(rig) == UNCALIBRATED
    ask(rig, codes.SETTING_DEFAULTS)
    assert ask(rig, codes.SETTING_SET, PLAIN, 121) == (121, codes.NO_REASON)
    assert reason(rig) == UNCALIBRATED
    assert ask(rig, codes.SETTING_GET, TURN)[0] == 174
    measured(rig, 170, 174)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON
    assert reason(rig) == codes.NO_REASON
    rig.boot()
    rig.run(1200)
    assert rig.wipers() == (170, 174)
    ask(rig, codes.SETTING_DEFAULTS)
    assert ask(rig, codes.SETTING_GET, TURN)[0] == 174  # not a preference
    rig.give(codes.ARM)
    rig.until(lambda: rig.app.safety.state == codes.ARMED, 300)


def test_each_change_starts_the_proof_of_neutral_again():
    rig = connected()
    ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, 172)
    ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, 170)  # back at what was saved
    rig.run(20)
    assert rig.app.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    waited_ms = rig.until(lambda: rig.app.safety.arm_reason == codes.NO_REASON, 600)
    assert waited_ms >= 450
    rig.arm()


def test_a_change_that_is_not_saved_ends_with_the_session():
    rig = connected()
    ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, 190)
    rig.run(2)
    assert rig.wipers() == (190, 170)
    rig.keys.end()
    rig.say_hello(SESSION + 1)
    rig.run(100)
    assert rig.neutral()
    assert ask(rig, codes.SETTING_GET, LINEAR)[0] == 170
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON  # and is not saved by the next
    rig.boot()
    rig.run(1200)
    assert rig.neutral()


def test_a_neutral_that_the_flash_refused_does_not_arm():
    rig = connected()

    def full(name, text):
        raise OSError(28)

    store = rig.files.store
    rig.files.store = full
    measured(rig, 175, 170)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_NOT_STORED
    rig.run(700)
    assert reason(rig) == UNCALIBRATED
    rig.files.store = store
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON
    rig.run(700)
    assert reason(rig) == codes.NO_REASON


def test_a_save_by_someone_else_does_not_keep_what_is_being_measured():
    rig = connected()
    measured(rig, 175, 190)
    ask(rig, codes.SETTING_SET, PROFILE, 2)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_BY_CALIBRATION
    ask(rig, codes.SETTING_SET_NEUTRAL, TURN, 172)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_BY_CALIBRATION
    assert reason(rig) == UNCALIBRATED
    measured(rig, 175, 172)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON
    rig.boot()
    rig.run(1200)
    assert rig.wipers() == (175, 172)


def test_damaged_settings_need_a_measured_neutral_whatever_else_is_asked():
    rig = connected()
    rig.files.texts["settings.json"] = "spoilt"
    rig.boot()
    rig.run(1200)
    ask(rig, codes.SETTING_DEFAULTS)
    assert ask(rig, codes.SETTING_SET, PROFILE, 2)[1] == codes.NO_REASON
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_BY_CALIBRATION
    assert reason(rig) == UNCALIBRATED
    measured(rig, 178, 170)
    rig.keys.end()
    rig.say_hello(SESSION + 1)
    rig.run(700)
    assert rig.neutral()
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_BY_CALIBRATION
    assert reason(rig) == UNCALIBRATED
    assert rig.files.texts["settings.json"] == "spoilt"
    measured(rig, 170, 170)  # which may well be the chair's own
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON
    rig.run(700)
    assert reason(rig) == codes.NO_REASON


def test_no_neutral_is_changed_while_armed():
    rig = Rig()
    rig.arm()
    assert ask(rig, codes.SETTING_SET_NEUTRAL, LINEAR, 172) == (170, codes.SETTING_WHILE_ARMED)
