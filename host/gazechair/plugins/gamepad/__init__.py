"""The input `gamepad`: a USB gamepad or joystick at the host."""

from gazechair.plugins.gamepad.gamepad import Gamepad

__all__ = ["Gamepad"]
