"""Raised when a camera cannot be opened or read."""


class CameraError(Exception):
    """The camera can't be used; the text is one plain line: what, where, what to do."""
