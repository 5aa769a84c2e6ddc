"""Takes the chair to a place: costmap, planner, path follower, mission."""
