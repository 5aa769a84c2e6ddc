"""Alerts: who is called, when, and whether somebody answered."""
