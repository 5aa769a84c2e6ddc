"""Checks of the code base: the import graph of the rooms, and the generated pages of docs/."""
