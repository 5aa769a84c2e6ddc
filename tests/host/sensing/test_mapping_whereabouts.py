"""The pose in the daemon: mapping's pose, extended by odometry, for a limited time."""

from __future__ import annotations

import json
import math
import time
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from gazechair.base.health import Health
from gazechair.sensing.mapping.locating.whereabouts import CONFIRMED_S, Fix, Whereabouts, onward
from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.odometry.estimate import Estimate

# In odometry's frame at (1, 2) looking along its y; in the map at (10, 0) looking along its x.
FIX = Fix(100.0, "home", 10.0, 0.0, 0.0, 0.02, 0.3, 0.9, (1.0, 2.0, 450.0), 7)
HERE = Estimate(
    100.0, 1.0, 2.0, 450.0, 0.5, 0.0, 10.0, 0.1, 0.1, 1.0, 0.02, 0.9, (), 7
)  # fmt: skip


def test_odometry_carries_the_place_on() -> None:
    there = onward(FIX, replace(HERE, time_s=100.5, x_m=1.5, y_m=3.0, heading_deg=440.0))
    assert there is not None
    assert (there.x_m, there.y_m) == pytest.approx((11.0, -0.5))
    assert there.heading_deg == pytest.approx(350.0)
    assert there.map == "home"
    assert there.time_s == 100.5
    assert there.sigma_m == pytest.approx(math.hypot(0.02, 0.02 * math.hypot(1.0, 0.5)))
    assert there.sigma_deg > FIX.sigma_deg
    turned = onward(replace(FIX, mounting_m=0.05, mounting_deg=5.5), HERE)
    assert turned is not None
    assert (turned.mounting_m, turned.mounting_deg) == (0.05, 5.5)


@pytest.mark.parametrize(
    "estimate",
    [
        replace(HERE, track=8),  # carried, or odometry's process is another
        replace(HERE, time_s=100.0 + CONFIRMED_S + 0.1),  # mapping says nothing any more
        replace(HERE, time_s=100.0 - CONFIRMED_S - 0.1),
    ],
)
def test_it_does_not_last(estimate: Estimate) -> None:
    assert onward(FIX, HERE) is not None
    assert onward(FIX, estimate) is None


def test_the_service_tells_with_each_estimate_until_mapping_knows_no_more(tmp_path: Path) -> None:
    service = MappingService((), tmp_path, Health("map"))
    heard: list[Whereabouts] = []
    service.subscribe(heard.append)
    now_s = time.monotonic()
    estimate = replace(HERE, time_s=now_s)
    service.estimate(estimate)
    assert not heard

    def says(state: str, fix: Fix | None, askew: bool = False) -> None:
        said = {"state": state, "making": None, "problem": "", "fix": fix and asdict(fix)}
        service._on_data(json.dumps({**said, "askew": askew, "twins": False}).encode())

    says("known", replace(FIX, time_s=now_s - 0.1))
    service.estimate(estimate)
    service.estimate(replace(estimate, x_m=1.2))
    assert [one.y_m for one in heard] == pytest.approx([0.0, -0.2])
    entry = service.latest.entry()
    assert entry is not None
    assert (entry.value, entry.born_s) == (heard[-1], now_s)
    service.estimate(replace(estimate, track=8))
    assert service.latest.get() is None
    service.estimate(estimate)
    says("unknown", None, True)
    assert service._health.now().reason == "lidar_turned"
    says("unknown", None)
    assert service.latest.get() is None
    service.estimate(estimate)
    assert service.latest.get() is None
    assert len(heard) == 3
    service.stop()
