"""`gazechair bench`: checks the wiring of potentiometer and heading sensor without a Teensy."""

from gazechair.service.bench.bench import Bench
from gazechair.service.bench.errors import BenchError

__all__ = ("Bench", "BenchError")
