"""Proves the safety core: exhaustive exploration, random runs, coverage and mutants."""
