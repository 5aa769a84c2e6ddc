"""What drives by itself: one child process for each kind, and its end in the daemon."""
