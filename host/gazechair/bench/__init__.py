"""`gazechair bench`: checks the wiring of potentiometer and heading sensor without a Teensy."""

from gazechair.bench.command import Bench
from gazechair.bench.errors import BenchError

__all__ = ("Bench", "BenchError")
