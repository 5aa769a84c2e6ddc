"""The chair's twin compared with the published turns of the first prototype: tables and plots."""
