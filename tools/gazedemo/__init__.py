"""The demo: starts simulator, firmware, host together; with its own check."""
