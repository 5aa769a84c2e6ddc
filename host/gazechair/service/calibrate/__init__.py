"""`gazechair calibrate`: the heading sensor's own calibration, and the joystick's neutral."""

from gazechair.service.calibrate.errors import CalibrateError
from gazechair.service.calibrate.heading import HeadingCalibration
from gazechair.service.calibrate.joystick import JoystickCalibration

__all__ = ("CalibrateError", "HeadingCalibration", "JoystickCalibration")
