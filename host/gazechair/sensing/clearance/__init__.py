"""Clearance: how far the chair may go in each direction until its footprint touches anything."""
