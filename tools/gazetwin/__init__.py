"""The chair's twin compared with the published turns of the first prototype: fit and plots."""
