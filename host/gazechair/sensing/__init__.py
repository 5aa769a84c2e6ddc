"""What surrounds the chair: the lidars, and the clearance of every motion."""
