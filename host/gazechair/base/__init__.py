"""Shared basics of every room: latest values, health, child processes, logs, the footprint."""
