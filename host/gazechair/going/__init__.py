"""Takes the chair to a place: costmap, planner, follower, and the mission from A to B."""
