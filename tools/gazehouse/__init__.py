"""Checks of the code base: the import graph of the rooms, the generated pages of docs/."""
