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
    received_s: float
    is_input: bool = False  # else a page
    refused: set[str] = field(default_factory=set)  # refusals already sent about its newest press
