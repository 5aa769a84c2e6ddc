"""The S2's noise, for simulated eyes that do without its bytes (s2_beams.py makes those)."""

NOISE_M = 0.006
"""Standard deviation of a range."""
MISSING = 0.003
"""Share of the beams without a return."""
