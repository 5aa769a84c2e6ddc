"""Auto motions: one child process for each kind, and its counterpart in the daemon."""
