"""What a camera that can't be used raises."""


class CameraError(Exception):
    """The camera can't be used; the text is one plain line: what, where, what to do."""
