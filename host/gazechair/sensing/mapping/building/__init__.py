"""A map from the key scans of one drive."""
