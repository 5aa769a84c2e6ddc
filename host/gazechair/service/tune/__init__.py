"""`gazechair tune`: measures on the chair how it turns and drives straight in a speed profile."""
