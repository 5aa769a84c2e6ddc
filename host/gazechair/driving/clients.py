"""The arbiter's clients: pages, and inputs alongside them."""

from __future__ import annotations

from dataclasses import dataclass, field

from gazelink import codes

# A viewer can never own the chair.
ROLES = {"driver": codes.DRIVER, "caretaker": codes.CARETAKER, "viewer": codes.NOBODY}


@dataclass
class Client:
    role: int  # as owner: codes.DRIVER, ...
    role_name: str
    heard_s: float
    beside: bool = False  # an input, not a page
    told: set[str] = field(default_factory=set)  # refusals already sent about its newest press
    bypass_told: int = 0  # edge of a bypass already refused
