"""The tiles whose person first chooses a spot of the picture: a line, a place on the floor."""

from __future__ import annotations

from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE
from gazechair.producers.places import Target

_TILES = {
    "line": ("follow-line", "Volg lijn", "Follow line", "〰️"),
    "look": ("go-look", "Ga waar ik kijk", "Go where I look", "\U0001f441"),
}


def spots(kind: str, allowed: bool, floor: FloorStore) -> dict[str, Target]:
    """The tile of a kind; `allowed`: its driver may be moved by itself.

    None without a calibrated camera whose pictures can be read.
    """
    known = floor.get() if allowed and CAN_DECODE else None
    if known is None:
        return {}
    mode, name, english, letters = _TILES[kind]
    more = {"aspect": known.camera.width_px / known.camera.height_px}
    return {mode: Target(name, "", more, english, letters)}
