"""Auto drives: to places, to spots, along lines, behind people, and help through doors."""
