"""`gazechair tune`: how this chair turns in a speed profile, found on the chair itself."""
