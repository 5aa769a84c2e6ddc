"""Calibrations for terminal and phone: the joystick's neutral, the camera above the floor."""
