"""Auto motions: one child process for each kind, with its counterpart in the daemon."""
