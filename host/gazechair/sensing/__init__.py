"""The chair's surroundings: the lidars, and the clearance of every motion."""
