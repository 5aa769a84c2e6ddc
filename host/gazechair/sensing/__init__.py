"""What surrounds the chair: lidars, clearance of every motion, odometry, map of the home."""
