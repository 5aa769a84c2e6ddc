"""The chair's pose in a known map."""
