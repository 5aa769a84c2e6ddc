"""Commands that a person runs from a terminal: flash, bench, calibrate, tune, doctor."""
