"""Tiles that open the choice of a spot: only with a calibrated camera, with its floor's top."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from gazechair.picture.floor import ABOVE_HORIZON, TOO_FAR, FloorCamera, NoSpot, Spot
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore
from gazechair.producers.tiles import spots


def camera(down_deg: float) -> FloorCamera:
    return FloorCamera(640, 480, 417.0, 1.15, math.radians(down_deg), x_m=0.3)


def top(folder: Path, one: FloorCamera) -> float:
    store = FloorStore(folder)
    store.keep(Calibration(one, 0.01, 0.01))
    (target,) = spots("look", True, store).values()
    assert target.more["aspect"] == pytest.approx(4 / 3)
    return float(target.more["top"])


@pytest.mark.parametrize("down_deg", [8.0, 20.0, 35.0])
def test_floor_within_reach_begins_below_top(tmp_path: Path, down_deg: float) -> None:
    share = top(tmp_path, camera(down_deg))
    below = camera(down_deg).spot((320.0, 480.0 * share + 4.0), 1.0)
    assert isinstance(below, Spot)
    above = camera(down_deg).spot((320.0, 480.0 * share - 4.0), 1.0)
    assert isinstance(above, NoSpot)
    assert above.reason in (TOO_FAR, ABOVE_HORIZON)


def test_a_camera_that_looks_far_down_or_hardly_down_has_a_top_too(tmp_path: Path) -> None:
    assert top(tmp_path, camera(80.0)) == 0.0
    assert 0.0 <= top(tmp_path, camera(-40.0)) <= 0.8


def test_without_a_calibration_or_permission_there_is_no_tile(tmp_path: Path) -> None:
    store = FloorStore(tmp_path)
    assert spots("look", True, store) == {}
    store.keep(Calibration(camera(20.0), 0.01, 0.01))
    assert spots("look", False, store) == {}
    assert list(spots("line", True, store)) == ["follow-line"]
