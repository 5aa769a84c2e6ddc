"""What all lidars' views together leave free: the content of outgoing.Clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gazechair.clearance.footprint import Footprint, Margins
from gazechair.clearance.reach import FREE, LidarReach, Reach
from gazechair.clearance.view import SweepView
from gazechair.config import FootprintConfig
from gazechair.lidar.scan import ChairView
from gazelink.messages import CLEAR_FAR

_PLAY = (0.04, 0.04, 2.0, 2.0)
"""A way grows only when it has grown by more than this (metres, metres, degrees, degrees)."""


def footprint_of(config: FootprintConfig) -> Footprint:
    """The footprint as configured."""
    margins = Margins(config.front_margin_m, config.side_margin_m, config.rear_margin_m)
    return Footprint(config.corners_m, margins)


class Evaluator:
    """Judges the views of all lidars, again with every call; the same lidars in the same order."""

    def __init__(self, footprint: Footprint, origins_m: Sequence[tuple[float, float]]) -> None:
        """`origins_m`: where each lidar sits."""
        self._view = SweepView(footprint, origins_m)
        self._lidars = tuple(LidarReach(footprint) for _ in origins_m)
        self._judged: list[tuple[ChairView | None, Reach]] = [(None, FREE)] * len(self._lidars)
        self._held = [0.0] * len(_PLAY)

    def __call__(self, views: tuple[ChairView, ...]) -> dict[str, int]:
        """Fields of outgoing.Clearance: ways, blocked and unseen bits.

        A direction is blocked here only where a lidar is blind; how near is too near the board
        decides.
        """
        for at, view in enumerate(views):
            if view is not self._judged[at][0]:
                self._judged[at] = (view, self._lidars[at].update(view))
        least = [min(reach[way] for _, reach in self._judged) for way in range(len(_PLAY))]
        self._held = [_held(*values) for values in zip(self._held, least, _PLAY, strict=True)]
        forward_m, backward_m, left_deg, right_deg = self._held
        blind, unseen = self._view.judge([view.states for view in views])
        return {
            "blocked": blind,
            "unseen": unseen,
            "forward_mm": _on_wire(1000.0 * forward_m),
            "backward_mm": _on_wire(1000.0 * backward_m),
            "left_q4_deg": _on_wire(16.0 * left_deg),
            "right_q4_deg": _on_wire(16.0 * right_deg),
        }


def _held(before: float, now: float, play: float) -> float:
    # Less counts at once; more only beyond the play, and without it: noise moves nothing.
    return now if now <= before else max(before, now - play)


def _on_wire(way: float) -> int:
    return CLEAR_FAR if math.isinf(way) else min(CLEAR_FAR - 1, int(way))
