"""Turns: ours and other controllers."""
