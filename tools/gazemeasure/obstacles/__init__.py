"""Obstacles and people before a driven chair."""
