"""Checks of the code base: which room imports which, and the generated pages of docs/."""
