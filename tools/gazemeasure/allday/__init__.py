"""A day of driving: faults, alerts, power cuts, replays."""
