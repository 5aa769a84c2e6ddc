"""`gazechair calibrate`: the heading sensor's own calibration, and the joystick's neutral."""

from gazechair.calibrate.errors import CalibrateError
from gazechair.calibrate.heading import HeadingCalibration
from gazechair.calibrate.joystick import JoystickCalibration

__all__ = ("CalibrateError", "HeadingCalibration", "JoystickCalibration")
