"""Pairs programs on this machine with a running host, through its local socket."""

from __future__ import annotations

import json
import urllib.request
from pathlib import Path

from gazechair.people.pairing.local import LONGEST_VALID_S, ask

_LIMIT_S = 20.0


def invitation(state_folder: Path, role: str = "driver", language: str = "") -> str:
    """An address that pairs the first browser to open it. Raises NotRunning, RequestRefused."""
    made = ask(state_folder, {"ask": "code", "role": role, "valid_s": LONGEST_VALID_S})
    query = f"?lang={language}" if language else ""
    return f"{made['url']}{query}#{made['code']}"


def is_open(state_folder: Path, address: str) -> bool:
    """True while no browser has used that address. Raises NotRunning, RequestRefused."""
    code = address.partition("#")[2]
    return bool(ask(state_folder, {"ask": "open", "code": code})["open"])


def cookie(state_folder: Path, role: str = "driver", name: str = "program") -> str:
    """The Cookie header of a newly paired device. Raises NotRunning, RequestRefused, OSError."""
    address, _, code = invitation(state_folder, role).partition("#")
    request = urllib.request.Request(
        address,
        json.dumps({"code": code, "name": name}).encode(),
        {"Content-Type": "application/json"},
    )
    with urllib.request.urlopen(request, timeout=_LIMIT_S) as answer:
        return str(answer.headers["Set-Cookie"]).partition(";")[0]
