"""The driver's page in a browser on a bad network; the host under floods."""
