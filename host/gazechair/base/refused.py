"""Raised when a person's request is refused, with a reason that the pages can show."""

from __future__ import annotations


class Refused(Exception):
    """`reason`: a key of the string tables; the text: one plain English line."""

    def __init__(self, reason: str, detail: str = "") -> None:
        super().__init__(detail or reason)
        self.reason = reason
