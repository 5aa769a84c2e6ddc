"""How well a scan fits what was seen before."""
