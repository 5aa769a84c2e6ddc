"""Proves the safety core by exploration, coverage and mutants; fuzzes the whole firmware."""
