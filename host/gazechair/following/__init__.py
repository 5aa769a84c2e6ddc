"""Follows what the chair sees: a line on the floor, or a person by the legs."""
