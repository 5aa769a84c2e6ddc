"""The demo in a home: a flat with a stored map and its places."""

from __future__ import annotations

import json
import urllib.request
from pathlib import Path

from gazechair.sensing.mapping.stored.store import FOLDER
from gazedemo.stack import Stack, StackError
from gazesim import plans, room_map

ROOM, LIDARS = "flat", 2
_MAP = "flat"


def prepare(state_folder: Path) -> None:
    """Store a map of the flat with its places."""
    path = state_folder / FOLDER / f"{_MAP}.map"
    room_map.store(plans.room(ROOM), plans.FLAT_PLACES, path)


def allow(stack: Stack) -> None:
    """Allow the driver, as a caretaker, to drive to places. Raises StackError."""
    headers = {"Cookie": stack.cookie("caretaker"), "Content-Type": "application/json"}
    request = urllib.request.Request(stack.url + "profiles", headers=headers)
    with urllib.request.urlopen(request, timeout=5) as answer:
        chosen = json.load(answer)["chosen"]
    body = json.dumps({"save": {"id": chosen, "auto": True}}).encode()
    request = urllib.request.Request(stack.url + "profiles", body, headers)
    with urllib.request.urlopen(request, timeout=5) as answer:
        saved = json.load(answer)
    if "profiles" not in saved:
        raise StackError(f"the caretaker could not allow it: {saved}")
