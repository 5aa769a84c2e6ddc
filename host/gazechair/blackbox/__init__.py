"""The black box: logs what happened to files that other tools open too."""
