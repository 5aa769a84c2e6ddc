"""The chair's twin held against what was published: the first prototype, fit, plots."""
