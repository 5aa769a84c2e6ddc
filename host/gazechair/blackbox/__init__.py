"""The black box: what happened, kept in files that other tools open too."""
