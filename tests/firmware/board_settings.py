# Settings over the wire: read, set, save, defaults; refused with the reason, and never while armed.

from gazelink import codes, messages
from gazelink.settings_table import TABLE, index_of
from gazesim.board_rig import Rig
from promiserig import ask

LINEAR = index_of("linear_permille")


def connected():
    rig = Rig()
    rig.run(1200)
    return rig


def test_every_setting_can_be_read():
    rig = connected()
    for index in range(len(TABLE)):
        assert ask(rig, codes.SETTING_GET, index) == (TABLE[index][1], codes.NO_REASON)
    assert ask(rig, codes.SETTING_GET, len(TABLE))[1] == codes.SETTING_UNKNOWN


def test_a_set_value_is_in_force_at_once_and_kept_after_a_save():
    rig = connected()
    assert ask(rig, codes.SETTING_SET, LINEAR, 250) == (250, codes.NO_REASON)
    rig.arm()
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    assert rig.wipers() == (170 + 250 * 84 // 1000, 170)
    rig.release()
    rig.give(codes.DISARM)
    rig.run(200)
    rig.boot()
    rig.run(1200)
    assert ask(rig, codes.SETTING_GET, LINEAR)[0] == 600  # not saved
    ask(rig, codes.SETTING_SET, LINEAR, 250)
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.NO_REASON
    rig.boot()
    rig.run(1200)
    assert ask(rig, codes.SETTING_GET, LINEAR)[0] == 250
    ask(rig, codes.SETTING_DEFAULTS)
    assert ask(rig, codes.SETTING_GET, LINEAR)[0] == 600


def test_refusals_say_why_and_change_nothing():
    rig = connected()
    assert ask(rig, codes.SETTING_SET, LINEAR, 1001) == (600, codes.SETTING_OUT_OF_RANGE)
    assert ask(rig, codes.SETTING_SET, 200, 5) == (0, codes.SETTING_UNKNOWN)
    rig.arm()
    for request in (codes.SETTING_SET, codes.SETTING_SAVE, codes.SETTING_DEFAULTS):
        assert ask(rig, request, LINEAR, 300) == (600, codes.SETTING_WHILE_ARMED)
    assert ask(rig, codes.SETTING_GET, LINEAR) == (600, codes.NO_REASON)
    bad = rig.app.link.incoming.bad
    rig.send(messages.SETTING, (9, 0, 0))
    rig.run(3)
    assert rig.app.link.incoming.bad == bad + 1


def test_a_full_flash_is_reported():
    rig = connected()

    def full(name, text):
        raise OSError(28)

    rig.files.store = full
    assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_NOT_STORED


def test_damaged_settings_keep_the_board_disarmed_until_calibrated_and_saved():
    rig = connected()
    rig.files.texts["settings.json"] = "spoilt"
    rig.boot()
    rig.run(1200)
    assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.CALIBRATION
    for name in ("neutral_linear_count", "neutral_turn_count"):
        ask(rig, codes.SETTING_SET_NEUTRAL, index_of(name), 170)
    ask(rig, codes.SETTING_SAVE)
    rig.run(50)
    assert rig.state["arm_reason"] == codes.NO_REASON
    rig.arm()


def test_telemetry_comes_as_often_as_asked():
    rig = connected()
    for period_ms, states in ((10, 100), (1, 1000), (50, 20)):
        rig.send(messages.TELEMETRY, (period_ms,))
        rig.run(10)
        rig.states = 0
        rig.run(1000)
        assert abs(rig.states - states) <= 1
    rig.send(messages.TELEMETRY, (0,))
    rig.send(messages.TELEMETRY, (101,))
    bad = rig.app.link.incoming.bad
    rig.run(5)
    assert rig.app.link.incoming.bad == bad + 2


def test_a_relay_contact_counts_from_the_moment_it_is_set_as_fitted():
    rig = connected()
    fitted = index_of("relay_fitted")
    rig.relay_works = False
    assert ask(rig, codes.SETTING_SET, fitted, 0) == (0, codes.NO_REASON)
    rig.arm()  # nobody tells what the relay does
    rig.give(codes.DISARM)
    rig.run(200)
    assert ask(rig, codes.SETTING_SET, fitted, 1) == (1, codes.NO_REASON)
    rig.run(1200)
    rig.give(codes.ARM)
    rig.until(lambda: rig.app.safety.faults & (1 << codes.RELAY_OPEN), 400)
    assert rig.app.safety.state == codes.DISARMED


def test_an_answer_never_goes_out_under_the_number_of_a_newer_question():
    rig = connected()
    rig.reply = None
    rig.wire.reading = False
    rig.send(messages.PING, (1, 2))
    rig.run(3)  # the answer to that waits in the line's buffer
    rig.send(messages.SETTING, (codes.SETTING_GET, index_of("relay_fitted"), 0))
    rig.run(3)
    rig.send(messages.SETTING, (codes.SETTING_GET, LINEAR, 0))
    # In the pass that takes the question, before its answer is made, the line is free again.
    rig.wire.reading = True
    rig.app.service()
    rig.listen()
    assert (rig.reply["index"], rig.reply["value"]) == (index_of("relay_fitted"), 1)
    rig.run(3)
    assert (rig.reply["index"], rig.reply["value"]) == (LINEAR, 600)
