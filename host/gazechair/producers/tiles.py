"""The tiles that need no map: follow a person, follow a line, go to a spot in the picture."""

from __future__ import annotations

import math

import numpy as np

from gazechair.picture.floor import FARTHEST_M, FloorCamera
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE
from gazechair.producers.places import Target

_MOST_TOP = 0.8  # for a camera that sees little floor
TILES = {
    "line": ("follow-line", "Volg lijn", "Follow line"),
    "look": ("go-look", "Ga waar ik kijk", "Go where I look"),
}


def people(allowed: bool) -> dict[str, Target]:
    """The tile that follows a person; `allowed`: this driver may use auto motions."""
    if not allowed:
        return {}
    return {"follow-person": Target("Volg persoon", "person", {}, "Follow person")}


def spots(kind: str, allowed: bool, floor: FloorStore) -> dict[str, Target]:
    """The tile of a kind whose person first chooses a spot.

    Empty without a calibrated camera whose pictures can be decoded.
    """
    known = floor.get() if allowed and CAN_DECODE else None
    if known is None:
        return {}
    mode, name, english = TILES[kind]
    camera = known.camera
    more = {"aspect": camera.width_px / camera.height_px, "top": _top(camera)}
    return {mode: Target(name, kind, more, english)}


def _top(camera: FloorCamera) -> float:
    """Fraction of the picture's height above which no floor within reach lies ahead."""
    v = float(camera.pixels(np.array(((FARTHEST_M, 0.0),)))[0, 1]) / camera.height_px
    return min(max(v, 0.0), _MOST_TOP) if math.isfinite(v) else 0.0
