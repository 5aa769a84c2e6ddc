"""Assist: while the driver holds forward, steers towards the free way ahead."""
