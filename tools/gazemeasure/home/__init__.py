"""Odometry, maps and localization."""
