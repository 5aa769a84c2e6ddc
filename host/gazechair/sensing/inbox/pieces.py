"""Half turns as measurements in the chair's frame, without what each lidar's mask hides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.lidar.scan import Pose, in_arcs

_TURN_S = 0.1


@dataclass(frozen=True)
class Piece:
    """Consecutive measurements of one lidar, in the order in which they were made.

    `directions_deg`: in the chair's frame, left positive. `distances_m`: 0 = no return.
    `origin_m`: the lidar's position. `times_s`: monotonic. `per_turn`: measurements in a turn.
    `lidar`: its index in the configuration. `as_of_s`: see `at_s`.
    """

    directions_deg: FloatArray
    distances_m: FloatArray
    times_s: FloatArray
    origin_m: tuple[float, float]
    per_turn: int
    lidar: int = 0
    as_of_s: float | None = None

    @property
    def middle_s(self) -> float:
        """The middle of its times."""
        return 0.5 * float(self.times_s[0] + self.times_s[-1])

    @property
    def at_s(self) -> float:
        """Time to which its points are moved and its estimate refers; the middle if not set."""
        return self.middle_s if self.as_of_s is None else self.as_of_s


class Lidars:
    """Mounting of each lidar, by its index in the configuration."""

    def __init__(self, configs: tuple[LidarConfig, ...]) -> None:
        self._configs = configs
        self._poses = [Pose(c.x_m, c.y_m, c.heading_deg, c.upside_down) for c in configs]

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]]) -> Lidars:
        """From the rows in a child's argument."""
        return cls(
            tuple(
                LidarConfig(**{**fields, "mask": tuple(tuple(arc) for arc in fields["mask"])})
                for fields in rows
            )
        )

    def piece(self, half: HalfTurn) -> Piece | None:
        """The half turn without masked measurements; None: nothing is left."""
        if half.lidar >= len(self._configs):
            return None
        config, pose = self._configs[half.lidar], self._poses[half.lidar]
        count = len(half.angles_deg)
        kept = np.flatnonzero(~in_arcs(half.angles_deg, config.mask))
        if not len(kept) or half.last_s <= half.first_s:
            return None
        return Piece(
            pose.directions_deg(half.angles_deg[kept]),
            half.distances_m[kept],
            np.linspace(half.first_s, half.last_s, count)[kept],
            (pose.x_m, pose.y_m),
            round(_TURN_S * (count - 1) / (half.last_s - half.first_s)),
            half.lidar,
        )
