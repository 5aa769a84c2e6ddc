"""Auto drives: to places, to spots, along lines, behind people; assist through doors."""
