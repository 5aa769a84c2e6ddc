"""Map of the home: built from one drive, stored, and searched for the chair's pose."""
