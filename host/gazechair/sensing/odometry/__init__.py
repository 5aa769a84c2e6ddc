"""Odometry without wheel encoders: motion from lidars with the heading, with its uncertainty."""
