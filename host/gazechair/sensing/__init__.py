"""The chair's surroundings: the lidars, the clearance of every motion, odometry."""
