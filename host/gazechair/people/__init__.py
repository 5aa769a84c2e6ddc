"""Who may use this chair: pairing and roles, and each person's profile."""
