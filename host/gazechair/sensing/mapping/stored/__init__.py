"""Maps as files and pictures."""
