"""What a person runs from a terminal beside the daemon: flash, bench, calibrate, tune, doctor."""
