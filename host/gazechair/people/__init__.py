"""The people who may use this chair: pairing, roles, and each person's profile."""
