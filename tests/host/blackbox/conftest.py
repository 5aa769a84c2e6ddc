"""One recorded drive for all tests of the black box."""

from __future__ import annotations

import array
from pathlib import Path

import pytest

from recordedchair import RecordedChair

BEAMS_MM = array.array("H", [0, *range(1000, 1719)])
JPEG = b"\xff\xd8small\xff\xd9"


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> RecordedChair:
    """Forward, stop, a step to the left, and everything else that can be recorded."""
    chair = RecordedChair(tmp_path_factory.mktemp("log"))
    chair.drive(ms=1000)
    chair.note("scan", ("front", BEAMS_MM.tobytes()))
    chair.note("places", [("front", 0.5, -0.1, 0.0, False), ("rear-left", -0.4, 0.3, 90.0, True)])
    chair.note("health", [("board", "ok", "ok", ""), ("lidar", "lost", "lidar_lost", "no \udce9")])
    chair.note("figures", {"late_ms": 1.5, "dropped": 0})
    chair.note("picture", JPEG)
    chair.note("line", (30, "gazechair.board", "session ended: unplugged \udce9"))
    chair.page.release()
    chair.run(500)
    chair.page.press("left", "step")
    chair.run(1500)
    chair.page.release()
    chair.run(810)
    chair.close()
    return chair


@pytest.fixture(scope="session")
def recorded(drive: RecordedChair) -> Path:
    """Its file."""
    return drive.path
