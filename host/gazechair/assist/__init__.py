"""Assist: while the driver holds forward, steers in the free direction."""
