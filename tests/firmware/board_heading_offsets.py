# The heading sensor's calibration is kept on the board and given back at every start.

from gazeboard.boards import bank_layout as at
from gazelink import codes, messages
from gazesim.board_rig import IMU, REGS, Rig
from promiserig import ask

CALIBRATION = IMU + REGS + 0x35
OFFSETS = IMU + REGS + 0x55


def save(rig):
    # The sensor changes its mode, which takes it some 30 ms.
    return ask(rig, codes.SETTING_SAVE_HEADING, within_ms=60)[1]


def calibrated_rig():
    rig = Rig()
    for k in range(22):
        rig.bank[OFFSETS + k] = 100 + k
    rig.bank[CALIBRATION] = 0x3F
    rig.run(2500)
    return rig


def test_offsets_are_stored_and_given_back_after_a_power_cut():
    rig = calibrated_rig()
    assert save(rig) == codes.NO_REASON
    assert "heading_offsets" in rig.files.texts
    for k in range(22):
        rig.bank[OFFSETS + k] = 0  # what a sensor forgets without power
    rig.boot()
    rig.run(500)
    for k in range(22):
        assert rig.bank[OFFSETS + k] == 100 + k
    rig.arm()


def test_saving_does_not_disturb_driving_afterwards():
    rig = calibrated_rig()
    assert save(rig) == codes.NO_REASON
    rig.run(1500)
    rig.arm()
    rig.press(codes.LEFT)
    rig.until(lambda: not rig.neutral(), 60)


def test_refused_while_armed_or_not_calibrated():
    rig = calibrated_rig()
    rig.arm()
    assert save(rig) == codes.SETTING_WHILE_ARMED
    rig.give(codes.DISARM)
    rig.run(50)
    rig.bank[CALIBRATION] = 0x0F  # the accelerometer alone
    rig.run(1500)
    assert save(rig) == codes.SENSOR_NOT_CALIBRATED
    assert "heading_offsets" not in rig.files.texts


def test_what_the_flash_refuses_is_not_called_stored():
    rig = calibrated_rig()
    store = rig.files.store

    def full(name, text):
        raise OSError(28)

    rig.files.store = full
    assert save(rig) == codes.SETTING_NOT_STORED
    assert "heading_offsets" not in rig.files.texts
    rig.files.store = store
    rig.run(1500)
    assert save(rig) == codes.NO_REASON
    assert "heading_offsets" in rig.files.texts


def test_a_sensor_that_is_lost_meanwhile_has_stored_nothing():
    rig = calibrated_rig()
    rig.reply = None
    rig.send(messages.SETTING, (codes.SETTING_SAVE_HEADING, 0, 0))
    rig.run(3)
    assert rig.reply is None
    rig.bank[IMU + at.SLOT_NAK] = 1
    rig.until(lambda: rig.reply is not None, 60)
    assert rig.reply["refused"] == codes.SENSOR_NOT_CALIBRATED
    assert "heading_offsets" not in rig.files.texts


def test_armed_meanwhile_it_stores_nothing():
    rig = calibrated_rig()
    rig.reply = None
    rig.send(messages.SETTING, (codes.SETTING_SAVE_HEADING, 0, 0))
    rig.run(3)
    rig.give(codes.ARM)
    rig.until(lambda: rig.reply is not None, 60)
    assert rig.reply["refused"] == codes.SETTING_WHILE_ARMED
    rig.give(codes.DISARM)
    rig.run(300)
    assert "heading_offsets" not in rig.files.texts


def test_another_request_meanwhile_is_answered_and_the_first_can_be_repeated():
    rig = calibrated_rig()
    rig.send(messages.SETTING, (codes.SETTING_SAVE_HEADING, 0, 0))
    rig.run(3)
    assert ask(rig, codes.SETTING_GET, 0) == (170, codes.NO_REASON)
    rig.run(300)
    assert "heading_offsets" not in rig.files.texts
    rig.run(1500)
    assert save(rig) == codes.NO_REASON
    assert "heading_offsets" in rig.files.texts


def test_damaged_offsets_are_not_used():
    rig = calibrated_rig()
    rig.files.texts["heading_offsets"] = "00" * 22 + "\n12345678\n"
    rig.boot()
    rig.run(500)
    assert rig.bank[OFFSETS] == 100


def test_the_sensor_is_back_in_fusion_mode():
    rig = calibrated_rig()
    assert save(rig) == codes.NO_REASON
    rig.run(300)
    assert rig.bank[IMU + REGS + 0x3D] == 8
    assert rig.bank[IMU + at.SLOT_WSEQ] > 0
