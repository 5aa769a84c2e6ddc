"""Map of the home: built from one drive, stored, searched for the chair's pose."""
