"""Turns: our controller compared with others."""
