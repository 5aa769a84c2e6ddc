"""The house itself: which room imports which, and the pages of docs/ made from the code."""
