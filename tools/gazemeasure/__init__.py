"""Benchmarks behind `gazechair measure NAME`: each measures, prints a table, checks limits."""
