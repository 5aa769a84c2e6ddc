"""Kind "line": pictures that are not of the calibrated camera's size; a speed cap too low."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from e2e.picture_chair import CAMERA, EYE
from gazechair.base.footprint import Footprint
from gazechair.driving.messages import LOWEST_CAP_PERMILLE
from gazechair.following.request import Request
from gazechair.going.mission import LIMIT
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import Shot
from gazechair.producers.contract import UNCALIBRATED, Ask, Output, Press, Sensed, Setup
from gazechair.producers.line import LineProducer
from gazechair.sensing.odometry.estimate import Estimate
from gazelink.settings_table import TABLE
from gazesim.floor_view import Floor, FloorView

TAPE = np.array(((0.8, 0.0), (4.0, 0.0)))
SETTINGS = {row[0]: row[1] for row in TABLE}
ANOTHER, NEARLY = (320, 180), (320, 238)


class Chair:
    """It stands before a tape, and its driver looks at that."""

    def __init__(self, folder: Path) -> None:
        FloorStore(folder).keep(Calibration(CAMERA, 0.01, 0.01))
        self._jpeg = FloorView(EYE, Floor(lines=[TAPE]), 3).jpeg(0.0, 0.0, 0.0)
        self._producer = LineProducer(Setup(Footprint(), Path("none"), folder))
        self._now_s = 100.0
        self.cap_permille = 1000
        self._producer.wait(self._sensed((320, 240)), self._now_s)
        u, v = EYE.pixel(1.7, 0.0)
        at = u / EYE.width_px, v / EYE.height_px
        self._producer.ask(Ask(1, at, SETTINGS, True, self._now_s))

    def _sensed(self, size: tuple[int, int]) -> Sensed:
        self._now_s += 0.05
        out = io.BytesIO()
        Image.open(io.BytesIO(self._jpeg)).resize(size).save(out, "JPEG")
        shot = Shot(out.getvalue(), self._now_s)
        estimate = Estimate(self._now_s, *(0.0,) * 10, 1.0, (), 1)
        return Sensed(estimates=[estimate], picture=shot, cap_permille=self.cap_permille)

    def waits(self, size: tuple[int, int]) -> Output:
        """With pictures of that size."""
        for _ in range(5):
            sent = self._producer.wait(self._sensed(size), self._now_s)
        return sent

    def drives(self, size: tuple[int, int], steps: int = 5) -> Output:
        """Pressed, with pictures of that size."""
        self._producer.press(Press(1, {"ask": 1}, SETTINGS, True, self._now_s))
        for _ in range(steps):
            sent = self._producer.step(self._sensed(size), self._now_s)
            if sent.stick is None:
                break
        return sent


@pytest.fixture
def chair(tmp_path: Path) -> Chair:
    return Chair(tmp_path)


def test_another_cameras_picture_is_refused_as_such(chair: Chair) -> None:
    sent = chair.waits(ANOTHER)
    assert (sent.state, sent.reason) == ("ended", UNCALIBRATED)


@pytest.mark.parametrize("size", [(320, 240), (640, 480), NEARLY])
def test_a_picture_of_the_calibrated_shape_is_used_at_any_size(
    chair: Chair, size: tuple[int, int]
) -> None:
    assert chair.waits(size).state == "ready"
    assert chair.drives(size).state == "drives"


def test_a_camera_that_is_replaced_ends_the_ride(chair: Chair) -> None:
    assert chair.waits((320, 240)).state == "ready"
    sent = chair.drives(ANOTHER)
    assert (sent.state, sent.reason) == ("ended", UNCALIBRATED)


def test_with_a_speed_cap_in_the_deadband_it_stands_and_says_so_until_it_is_raised(
    chair: Chair,
) -> None:
    assert chair.waits((320, 240)).state == "ready"
    chair.cap_permille = LOWEST_CAP_PERMILLE
    sent = chair.drives((320, 240), steps=40)
    assert (sent.stick, sent.state, sent.reason) == ((0, 0), "waits", LIMIT)
    chair.cap_permille = 1000
    assert chair.drives((320, 240)).state == "drives"


def test_with_a_speed_cap_too_low_to_turn_to_the_line_it_stands_and_says_so(chair: Chair) -> None:
    assert chair.waits((320, 240)).state == "ready"
    follower = chair._producer._follower
    assert follower is not None
    follower.step = lambda *_: Request(0.0, 0.3)  # type: ignore[method-assign]
    chair.cap_permille = 150
    sent = chair.drives((320, 240), steps=40)
    assert (sent.stick, sent.state, sent.reason) == ((0, 0), "waits", LIMIT)
    chair.cap_permille = 1000
    assert chair.drives((320, 240)).state == "drives"
