"""Combines the views of all lidars into one clearance: the content of board_commands.Clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from gazechair.base.arrays import ByteArray
from gazechair.base.footprint import Footprint, Margins
from gazechair.config.settings import FootprintConfig
from gazechair.sensing.clearance.reach import FREE, LidarReach, Reach
from gazechair.sensing.clearance.view import SweepView
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar.scan import ChairView
from gazelink import arcs
from gazelink.messages import CLEAR_FAR

_PLAY = (0.04, 0.04, 2.0, 2.0)
"""An increase counts less this much, so that noise has no effect (m, m, degrees, degrees)."""
_ARC_PLAY = round(1000.0 * _PLAY[0] / arcs.UNIT_MM)
_LESS_PLAY = np.maximum(np.arange(256), _ARC_PLAY) - _ARC_PLAY
_LESS_PLAY[arcs.FAR] = arcs.FAR
_LESS_PLAY = _LESS_PLAY.astype(np.uint8)
"""For each byte of the arcs: its value less the play."""


def footprint_of(config: FootprintConfig) -> Footprint:
    """The footprint as configured."""
    margins = Margins(config.front_margin_m, config.side_margin_m, config.rear_margin_m)
    return Footprint(config.corners_m, margins)


class Evaluator:
    """Evaluates the views of all lidars with each call; the same lidars in the same order."""

    def __init__(self, footprint: Footprint, origins_m: Sequence[tuple[float, float]]) -> None:
        """`origins_m`: where each lidar sits."""
        self._view = SweepView(footprint, origins_m)
        self._lidars = tuple(LidarReach(footprint) for _ in origins_m)
        self._judged: list[tuple[ChairView | None, Reach]] = [(None, FREE)] * len(self._lidars)
        self._zone = UNKNOWN
        self.zone: StopZone = UNKNOWN
        """The stop zone; any thread may replace it, which counts from the next call on."""
        self._steady = [0.0] * len(_PLAY)
        self._steady_arcs: ByteArray = np.zeros(arcs.SIZE, dtype=np.uint8)

    def __call__(self, views: tuple[ChairView, ...]) -> dict[str, Any]:
        """Fields of board_commands.Clearance: clearances, blocked and unseen bits; JSON values.

        A direction is blocked here only where a lidar is blind; the board decides which distance
        is too near.
        """
        zone = self.zone
        if zone is not self._zone:
            self._use(zone)
        for at, view in enumerate(views):
            if view is not self._judged[at][0]:
                others = (*self._lidars[:at], *self._lidars[at + 1 :])
                self._judged[at] = (view, self._lidars[at].update(view, others))
        least = map(min, zip(*(reach for _, reach in self._judged), strict=True))
        self._steady = [_steady(*values) for values in zip(self._steady, least, _PLAY, strict=True)]
        forward_m, backward_m, left_deg, right_deg = self._steady
        states = [view.states for view in views]
        blind, unseen, arc_views = self._view.judge(states)
        now = reduce(np.minimum, [lidar.arcs for lidar in self._lidars])
        self._steady_arcs = np.minimum(now, np.maximum(self._steady_arcs, _LESS_PLAY.take(now)))
        return {
            "blocked": blind,
            "unseen": unseen,
            "forward_mm": _on_wire(1000.0 * forward_m),
            "backward_mm": _on_wire(1000.0 * backward_m),
            "left_q4_deg": _on_wire(16.0 * left_deg),
            "right_q4_deg": _on_wire(16.0 * right_deg),
            "arc_views": arc_views,
            "arcs": self._steady_arcs.tolist(),
        }

    def _use(self, zone: StopZone) -> None:
        self._zone = zone
        self._view.use(zone)
        for lidar in self._lidars:
            lidar.use(zone)
        self._judged = [(None, FREE)] * len(self._lidars)  # evaluate each view again


def _steady(before: float, now: float, play: float) -> float:
    # A decrease counts at once, an increase less the play: noise has no effect.
    return now if now <= before else max(before, now - play)


def _on_wire(way: float) -> int:
    return CLEAR_FAR if math.isinf(way) else min(CLEAR_FAR - 1, int(way))
