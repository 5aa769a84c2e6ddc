"""Replay: runs the recorded inputs of a board's ticks through the real safety core again."""
