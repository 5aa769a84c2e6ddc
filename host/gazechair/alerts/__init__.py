"""Alerts: whom to call, when, and whether somebody answered."""
