"""Exact odometry of a simulated chair, for tests of parts that use it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gazechair.base.latest_value import Entry
from gazechair.sensing.odometry.estimate import Estimate

KNOWN = Estimate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 1.0, 0.02, 0.9, (), 0)


class Measured:
    """The newest estimate, 20 times a second; of any rig with a world and a clock."""

    def __init__(self, rig: Any, *doubts: str) -> None:
        self.rig = rig
        self.doubts = doubts

    def __call__(self) -> Entry[Estimate]:
        chair, time_s = self.rig.world.chair, self.rig.now_s()
        found = replace(
            KNOWN, time_s=time_s, x_m=chair.x_m, y_m=chair.y_m, doubts=tuple(self.doubts)
        )
        return Entry(found, time_s, self.rig.now_ms // 50)
