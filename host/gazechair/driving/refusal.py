"""Refusal: why a page's message was not followed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Refusal:
    """Why a message was not followed."""

    what: str
    """ "cmd", "drive", "arm", "take", "reset", "bypass", "cap", "call", "spot" or "message"."""
    reason: str
    """A key of the string tables."""
    detail: str

    def message(self) -> dict[str, str]:
        """As sent to the page."""
        return {"k": "refused", "what": self.what, "reason": self.reason, "detail": self.detail}
