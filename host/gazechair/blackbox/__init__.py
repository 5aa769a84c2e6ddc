"""The black box: a log of what happened, in files that other tools can open too."""
