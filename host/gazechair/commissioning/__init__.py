"""Procedures that set up and measure the chair, for the terminal and the phone."""
