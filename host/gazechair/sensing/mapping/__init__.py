"""The map of the home in the daemon: made, kept current, used to locate the chair."""
