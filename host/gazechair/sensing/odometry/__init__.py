"""Odometry without wheel encoders: pose, speed and their uncertainty from lidars and heading."""
