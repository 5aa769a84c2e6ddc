"""A recorded drive from above: where the simulated chair was, and what it saw."""

from __future__ import annotations

import array
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from gazechair.blackbox.reader import LogFile
from gazereplay import view
from recordedchair import RecordedChair

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("replay_view")

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def chair(tmp_path_factory: pytest.TempPathFactory) -> RecordedChair:
    """Turned, driven, stopped by an obstacle."""
    chair = RecordedChair(tmp_path_factory.mktemp("view"))
    chair.note("places", [("front", 0.5, 0.0, 0.0, False)])
    chair.drive("left", ms=1500)
    chair.page.release()
    chair.run(1000)
    chair.page.press("forward")
    chair.run(1500)
    chair.world.faults.inject("obstacle", ahead_m=1.0, left_m=0.0, size_m=0.2)
    # A wall 2 m before the lidar, in its middle 10 degrees.
    beams = [2000 if abs(beam - 360) < 10 else 0 for beam in range(720)]
    chair.note("scan", ("front", array.array("H", beams).tobytes()))
    chair.until(lambda: chair.override() == "obstacle_forward", 1000)
    chair.run(1500)
    chair.close()
    return chair


@pytest.fixture(scope="module")
def drive(chair: RecordedChair) -> view.Drive:
    return view.follow(LogFile(chair.path).lines())


def test_the_path_ends_where_the_chair_is(chair: RecordedChair, drive: view.Drive) -> None:
    truth: Any = chair.world.chair
    x_m, y_m, heading_deg = drive.events[-1].pose
    assert math.hypot(truth.x_m, truth.y_m) > 0.2
    assert math.dist((x_m, y_m), (truth.x_m, truth.y_m)) < 0.02  # in this room both begin alike
    assert heading_deg == pytest.approx(truth.heading_deg, abs=1.0)


def test_what_stopped_it_is_told_where_it_was_seen(drive: view.Drive) -> None:
    texts = [event.text for event in drive.events]
    assert "obstacle_forward" in texts
    assert texts[-1] == "end"
    event = drive.events[texts.index("obstacle_forward")]
    x_m, y_m, heading_deg = event.pose
    assert len(event.scan) == 19
    for seen_x, seen_y in event.scan:
        assert math.hypot(seen_x - x_m, seen_y - y_m) == pytest.approx(2.5, abs=0.02)
        way_deg = math.degrees(math.atan2(seen_y - y_m, seen_x - x_m))
        assert (way_deg - heading_deg + 180) % 360 - 180 == pytest.approx(0.0, abs=5.0)


def test_the_picture_is_one(drive: view.Drive, tmp_path: Path) -> None:
    target = tmp_path / "drive.svg"
    view.draw(drive, target)
    root = ElementTree.parse(target).getroot()
    assert len(root.findall(f"{SVG}circle")) >= 19
    texts = [text.text or "" for text in root.findall(f"{SVG}text")]
    assert any("obstacle_forward" in text for text in texts)
    assert "estimated" in texts[-1]


def test_an_empty_log_is_drawn_too(tmp_path: Path) -> None:
    view.draw(view.follow([]), tmp_path / "nothing.svg")
    ElementTree.parse(tmp_path / "nothing.svg")
