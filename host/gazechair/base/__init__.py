"""What every room builds on: latest values, health, child processes, logs, the footprint."""
