"""Map of the home in the daemon: made, kept current, used for the pose; its rooms do each."""
