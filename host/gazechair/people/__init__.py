"""The people who may use this chair: each with devices, a role, a profile."""
