"""`gazechair bench`: checks the wiring of potentiometer and heading sensor without a Teensy."""

from gazechair.base.told import ToldError


class BenchError(ToldError):
    """Raised when a device stops answering or a library is missing."""
