"""The newest full turn of the lidar, assembled on the S flag and renewed with every few nodes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gazechair.base.angles import in_turn_if_near
from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.sensing.lidar.nodes import Nodes, wrapped_steps
from gazechair.sensing.lidar.scan import BINS, PLACED_ROWS, Placing, Scan
from gazelink import codes

NODE_PERIOD_S = 1.0 / 16_000.0  # standard scan: 16 kHz
_LONGEST_TURN_S = 0.5  # after this long, the S flag was lost several times
_FOLLOW = 0.2  # weight of a turn in the rate
# A dense capsule is decoded when the next one is complete: a quarter does not wait for its last.
_ALL_BUT_DEG = 2.0
_JITTER_DEG = 5.0  # of the angle at which a turn starts
_KEPT = 3  # turns kept besides the one in progress
_NONE: FloatArray = np.zeros(0)

_Nodes = FloatArray  # rows of all nodes: angles, times, the placing's if there is one
_ANGLE, _TIME, _PLACED, _DISTANCE = 0, 1, 2, -1  # the placing's last row are the distances


class Sweep:
    """Joins the turn in progress with the part of the turn before it that it has not yet reached.

    So an obstacle appears some 25 ms after its beam, instead of up to a whole turn later.

    Degrees whose measurements were all lost get the values of the two turns before, for one more
    turn; then they are missing. If either turn has no measurement there, they are missing at once.
    So a wrong measurement never makes a direction free for a second turn.
    """

    def __init__(
        self,
        source: int = codes.SIMULATED,
        period_s: float = NODE_PERIOD_S,
        placing: Placing | None = None,
    ) -> None:
        """`source` marks the scans; with any but codes.REAL a real board never arms.

        `period_s`: from one measurement to the next. `placing`: places each measurement once.
        """
        self.turns = 0
        self.rate_hz = 0.0
        """Measured turns per second; 0 before that is known."""
        self._turn_s: float | None = None
        self._source = source
        self._period_s = period_s
        self._most_nodes = round(_LONGEST_TURN_S / period_s)
        self._placing = placing
        self._turns = [_Turn(self._rows(_NONE, _NONE, _NONE)) for _ in range(1 + _KEPT)]
        """Newest first."""

    def add(self, nodes: Nodes, received_s: float) -> Scan | None:
        """Take nodes that were complete at `received_s`; the newest scan, None without nodes."""
        self.take(nodes, received_s)
        return self.scan() if len(nodes) else None

    def take(self, nodes: Nodes, received_s: float) -> None:
        """Take nodes that were complete at `received_s`, CLOCK_MONOTONIC seconds."""
        times_s = received_s - nodes.backlog.astype(np.float64) * self._period_s
        cuts = [0, *nodes.starts.nonzero()[0].tolist(), len(nodes)]
        rows = self._rows(nodes.angles_deg, nodes.distances_m, times_s)
        for first, last in pairwise(cuts):
            if first < last:
                if nodes.starts[first]:
                    self._turns = [_Turn(rows[:, :0]), *self._turns[:_KEPT]]
                    self.turns += 1
                    self._clock_turn(float(times_s[first]))
                self._turns[0].add(rows[:, first:last], self._most_nodes)

    def _rows(self, angles_deg: FloatArray, distances_m: FloatArray, times_s: FloatArray) -> _Nodes:
        if self._placing is None:
            return np.stack((angles_deg, times_s, distances_m))
        rows = np.empty((_PLACED + PLACED_ROWS, len(angles_deg)))
        rows[_ANGLE], rows[_TIME] = angles_deg, times_s
        self._placing(angles_deg, distances_m, rows[_PLACED:])
        return rows

    def _clock_turn(self, now_s: float) -> None:
        if self._turn_s is not None and now_s > self._turn_s:
            seen_hz = 1.0 / (now_s - self._turn_s)
            self.rate_hz += (seen_hz - self.rate_hz) * (_FOLLOW if self.rate_hz else 1.0)
        self._turn_s = now_s

    @property
    def quarter(self) -> int:
        """Number of completed quarter turns of the mirror, up to a degree or two early."""
        return self.turns * 4 + self._turns[0].quarter

    @property
    def left_deg(self) -> float:
        """Degrees from the newest node to the end of its quarter turn."""
        return self._turns[0].left_deg

    def scan(self) -> Scan | None:
        """The newest scan, None before the first node and right at the start of a turn."""
        angles = self._turns[0].angles_deg()
        if not len(angles):
            return None
        # The mirror's angle by the lidar's own count: summed along the nodes, so that jitter about
        # the start of the turn does not count as a whole turn.
        first_deg = float(-angles[0] % 360.0)
        turned_deg = -float(wrapped_steps(angles).sum())
        reached_deg = first_deg - (360.0 if first_deg > 360.0 - _JITTER_DEG else 0.0) + turned_deg

        def view(back: int) -> _Nodes:
            # The whole turn that ended at the newest node's angle, `back` turns ago.
            newer, older = self._turns[back : back + 2]
            return _join(newer.until(reached_deg), older.beyond(reached_deg))

        older = self._turns[1].beyond(reached_deg)
        whole = _join(*self._turns[0].pieces, older)
        missing = np.bincount(_bins(older), minlength=BINS) + self._turns[0].by_bin == 0
        if np.count_nonzero(missing):
            whole = _fill(whole, missing, view(1), view(2))
        oldest_s = float(whole[_TIME].min())
        placed = whole[_PLACED:] if self._placing is not None else None
        return Scan(whole[_ANGLE], whole[_DISTANCE], oldest_s, self._source, placed, self._placing)


class _Turn:
    def __init__(self, nothing: _Nodes) -> None:
        self._nothing = nothing
        self.pieces: list[_Nodes] = []
        self.by_bin: IntArray = np.zeros(BINS, dtype=np.int64)
        """How many nodes it has in each degree."""
        self._count = 0
        self._turned_deg: FloatArray | None = None  # of each node, by the lidar's own count
        self.quarter = 0
        self.left_deg = 90.0

    def add(self, piece: _Nodes, most: int) -> None:
        by_bin = np.bincount(_bins(piece), minlength=BINS)
        self.pieces.append(piece)
        self._count += piece.shape[1]
        self.by_bin += by_bin
        if self._count > most:
            self.pieces, self.by_bin = [piece], by_bin
            self._count = piece.shape[1]
        self._turned_deg = None
        quarter, turned_deg = divmod(float(-piece[_ANGLE, -1] % 360.0 + _ALL_BUT_DEG), 90.0)
        self.quarter, self.left_deg = int(quarter), 90.0 - turned_deg

    def angles_deg(self) -> FloatArray:
        if not self.pieces:
            return np.asarray(self._nothing[_ANGLE])
        return np.concatenate([piece[_ANGLE] for piece in self.pieces])

    def joined(self) -> _Nodes:
        if not self.pieces:
            return self._nothing
        if len(self.pieces) > 1:
            self.pieces = [_join(*self.pieces)]
        return self.pieces[0]

    def until(self, reached_deg: float) -> _Nodes:
        """Its nodes up to this angle of the mirror."""
        return _pick(self.joined(), self._turned() <= reached_deg)

    def beyond(self, reached_deg: float) -> _Nodes:
        """Its nodes beyond this angle of the mirror."""
        return _pick(self.joined(), self._turned() > reached_deg)

    def _turned(self) -> FloatArray:
        # A whole turn is looked at four times.
        if self._turned_deg is None:
            self._turned_deg = in_turn_if_near(-self.joined()[_ANGLE], 360.0)
        return self._turned_deg


def _fill(newest: _Nodes, missing: BoolArray, before: _Nodes, oldest: _Nodes) -> _Nodes:
    """`newest`, with its missing degrees filled from the two views before it."""
    bins_before, bins_oldest = _bins(before), _bins(oldest)
    chosen = missing & (np.bincount(bins_before, minlength=BINS) > 0)
    chosen &= np.bincount(bins_oldest, minlength=BINS) > 0
    filled = _join(newest, _pick(before, chosen[bins_before]))
    # Only obstacles of the oldest: they can only reduce a clearance, so their age does not count.
    obstacles = _pick(oldest, chosen[bins_oldest] & (oldest[_DISTANCE] > 0.0)).copy()
    obstacles[_TIME] = np.inf
    return _join(filled, obstacles)


def _bins(nodes: _Nodes) -> IntArray:
    return np.asarray(np.minimum((nodes[_ANGLE] + 180.0).astype(np.int64), BINS - 1))


def _pick(nodes: _Nodes, chosen: BoolArray) -> _Nodes:
    """The chosen columns: a view if they are neighbours, as nearly always."""
    at = chosen.nonzero()[0]
    if len(at) and at[-1] - at[0] + 1 == len(at):
        return nodes[:, at[0] : at[-1] + 1]
    return nodes.take(at, axis=1)


def _join(*nodes: _Nodes) -> _Nodes:
    return np.concatenate(nodes, axis=1)
