"""The tile that follows a line on the floor."""

from __future__ import annotations

from gazechair.picture.floor_store import FloorStore
from gazechair.picture.pixels import CAN_DECODE
from gazechair.producers.places import Target


def lines(allowed: bool, floor: FloorStore) -> dict[str, Target]:
    """Follow the line that is chosen in the picture; `allowed`: its driver may be moved by itself.

    None without a calibrated camera whose pictures can be read.
    """
    known = floor.get() if allowed and CAN_DECODE else None
    if known is None:
        return {}
    more = {"aspect": known.camera.width_px / known.camera.height_px}
    return {"follow-line": Target("Volg lijn", "", more, "Follow line", "〰️")}
