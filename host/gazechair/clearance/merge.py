"""All lidars' words joined into what the board is told: outgoing.Clearance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gazechair.clearance.footprint import Footprint
from gazechair.clearance.reach import Reach
from gazechair.clearance.view import States, SweepView
from gazechair.lidar.blind import BINS, BLIND
from gazechair.outgoing import Clearance
from gazelink import codes
from gazelink.messages import CLEAR_FAR

STALE_S = 0.25
"""A lidar whose newest view is older than this, while another one lives, is blind all round."""
_PLAY = (0.04, 0.04, 2.0, 2.0)
"""A way grows only when it has grown by more than this (metres, metres, degrees, degrees)."""


@dataclass(frozen=True)
class Word:
    """What one lidar says."""

    reach: Reach
    states: States
    """(360,): SEEN, BLIND or MASKED, of the chair's frame."""
    acquired_s: float
    source: int


class Merger:
    """Joins the words of the lidars in `origins_m` (name: where it sits)."""

    def __init__(self, footprint: Footprint, origins_m: Mapping[str, tuple[float, float]]) -> None:
        self._names = tuple(origins_m)
        self._view = SweepView(footprint, tuple(origins_m.values()))
        self._words: dict[str, Word] = {}
        self._held = [0.0] * len(codes.DIRECTIONS)

    def hear(self, name: str, word: Word) -> Clearance:
        """The clearance after `word` of the lidar called `name`: as old as the oldest word used.

        A lidar that has been silent for STALE_S, or has said nothing yet, sees nothing: what only
        it sees is blocked, and the others go on.
        """
        self._words[name] = word
        newest_s = max(w.acquired_s for w in self._words.values())
        used = {n: w for n, w in self._words.items() if newest_s - w.acquired_s <= STALE_S}
        none = np.full(BINS, BLIND, dtype=np.uint8)
        blind, unseen = self._view.judge(
            [used[n].states if n in used else none for n in self._names]
        )
        least = [min(w.reach[at] for w in used.values()) for at in range(len(_PLAY))]
        self._held = [_held(*values) for values in zip(self._held, least, _PLAY, strict=True)]
        forward_m, backward_m, left_deg, right_deg = self._held
        return Clearance(
            blocked=blind,
            source=max(w.source for w in used.values()),
            acquired_s=min(w.acquired_s for w in used.values()),
            unseen=unseen,
            forward_mm=_on_wire(1000.0 * forward_m),
            backward_mm=_on_wire(1000.0 * backward_m),
            left_q4_deg=_on_wire(16.0 * left_deg),
            right_q4_deg=_on_wire(16.0 * right_deg),
        )


def _held(before: float, now: float, play: float) -> float:
    # Less counts at once; more only beyond the play, and without it: noise moves nothing.
    return now if now <= before else max(before, now - play)


def _on_wire(way: float) -> int:
    return CLEAR_FAR if math.isinf(way) else min(CLEAR_FAR - 1, int(way))
