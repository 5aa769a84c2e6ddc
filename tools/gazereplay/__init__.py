"""Replay: what a board took in each tick, recorded, through the real safety core once more."""
