"""Refusal: why a page's message was not followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gazechair.driving.messages import (
    Arm,
    Call,
    Cap,
    Drive,
    HoldBypass,
    PageMessage,
    Reset,
    Take,
    UseMode,
)
from gazelink import codes

What = Literal[
    "cmd",
    "drive",
    "arm",
    "take",
    "reset",
    "bypass",
    "cap",
    "call",
    "step",
    "spot",
    "message",
]
"""What can be refused; a mode's press is "drive", "message" one that is none of the others."""


@dataclass(frozen=True)
class Refusal:
    """Why a message was not followed."""

    what: What
    reason: str
    """A key of the string tables."""
    detail: str

    def message(self) -> dict[str, str]:
        """As sent to the page."""
        return {"k": "refused", "what": self.what, "reason": self.reason, "detail": self.detail}


_OF_TYPE: dict[type, What] = {
    UseMode: "drive",
    Arm: "arm",
    Take: "take",
    Reset: "reset",
    HoldBypass: "bypass",
    Cap: "cap",
    Call: "call",
}


def what_of(message: PageMessage) -> What:
    """What a refusal of this message names."""
    if isinstance(message, Drive):
        return "drive" if message.verb == codes.DRIVE else "cmd"
    return _OF_TYPE.get(type(message), "message")
