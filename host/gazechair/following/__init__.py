"""Followers of a person (legs in lidar scans) and of a line on the floor: request the motion."""
