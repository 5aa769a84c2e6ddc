"""A scan as stored in the log."""

from __future__ import annotations

import array

import numpy as np
import pytest

from gazechair.sensing.lidar.recorded import BEAMS, pack, unpack
from gazechair.sensing.lidar.scan import Scan
from gazelink import codes


def beams(angles_deg: list[float], distances_m: list[float]) -> array.array[int]:
    scan = Scan(np.array(angles_deg), np.array(distances_m), 12.5, codes.REAL)
    name, acquired_s, beams_mm = unpack(pack("front", scan))
    assert (name, acquired_s) == ("front", 12.5)
    return array.array("H", beams_mm)


@pytest.mark.parametrize(
    ("angle_deg", "beam"), [(-180.0, 0), (-179.6, 0), (0.0, 360), (90.0, 540), (179.99, 719)]
)
def test_a_return_is_in_the_beam_of_its_angle(angle_deg: float, beam: int) -> None:
    found = beams([angle_deg], [1.234])
    assert len(found) == BEAMS
    assert [at for at, mm in enumerate(found) if mm] == [beam]
    assert found[beam] in (1233, 1234)


def test_the_nearest_return_counts_and_none_is_0() -> None:
    found = beams([10.0, 10.1, 10.2, 20.0], [2.0, 0.5, 0.0, 0.0])
    assert found[380] == 500
    assert sum(1 for mm in found if mm) == 1


def test_too_far_is_far() -> None:
    assert beams([0.0], [80.0])[360] == 65534


def test_a_scan_without_measurements() -> None:
    assert not any(beams([], []))
