"""`gazechair bench`: checks the wiring of potentiometer and heading sensor without a Teensy."""

from gazechair.base.user_error import UserError


class BenchError(UserError):
    """Raised when a device stops answering or a library is missing."""
