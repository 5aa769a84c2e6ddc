"""Builds one Debian package with everything the host needs, for machines without internet."""
