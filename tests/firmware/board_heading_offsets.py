# The heading sensor's calibration is kept on the board and given back at every start.

from gazeboard.boards import bank_layout as at
from gazelink import codes
from gazesim.board_rig import IMU, REGS, Rig
from promiserig import ask

CALIBRATION = IMU + REGS + 0x35
OFFSETS = IMU + REGS + 0x55


def save(rig):
    return ask(rig, codes.SETTING_SAVE_HEADING)[1]


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
    rig.run(300)
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
