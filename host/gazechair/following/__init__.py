"""Followers, of a person by the legs or of a line on the floor: request the motion."""
