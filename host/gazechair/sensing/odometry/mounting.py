"""Detects a lidar that is turned on its mount, which rotates everything that it sees.

The drive axle does not slip sideways: if the chair seems to slip while it drives straight, always
to the same side, a lidar is turned. Until half a metre straight on has shown that it does not,
nobody knows how the lidars sit: one may have been bumped while nobody looked. Standing shows
nothing, and turning on the spot moves a turned lidar's axle as a lidar does whose place was
measured a centimetre wrong. If the lidars see a turn that the heading sensor does not, one may
just have been bumped; driving straight (and turning, if the suspicion arose in a turn) then
confirms or clears it. Two lidars that see different headings are not both mounted as configured.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from gazechair.sensing.odometry.shared_walls import NOT_COMPARED, Compared

_STRAIGHT_DEG_S = 3.0  # slower counts as straight, or standing
_MATCHED = 0.5  # share of the points; less is a crowd
# Suspicious difference between the turn by lidars and by the sensor, plus a share of the last
# second's turn, for the sensor's scale error. A far larger difference is the sensor's fault.
_JUMP_DEG, _JUMP_SHARE, _MOST_DEG, _SETTLED_DEG = 0.35, 0.04, 30.0, 0.3
_PIECE_DEG = 0.65  # the same, for a single piece
_TURNED_S = 1.0
_STEP_S, _STEP_M = 0.25, 0.02
# A mounting may be so far off. What the chair seems to slip sideways beyond that adds up, for each
# side; one step counts for no more than the last, as it does when somebody pushes the chair.
_ALLOWED, _SLIPS_M, _MOST_M = math.tan(math.radians(1.3)), 0.015, 0.009
_SMEARED_M = 0.15  # what is remembered lies so far off along a corridor, at most
# Straight on without slip: then the lidars are known to sit right, or again after a suspicion.
_KNOWN_M, _CLEARS_M = 0.5, 2.0
_SIGMA_DEG, _NOT_KNOWN_DEG, _TURNED_DEG = 1.0, 5.5, 7.0  # standard deviations
_MISFIT = 0.2  # share of the newest piece in the average of what does not fit, by lidar
_UNSEEN_S = 1.0  # without a piece for this long, nobody knows what was done to the lidars
# Averages of each lidar's heading while driving straight: against the sensor, or the other lidar.
_OFF_DEG, _OFF_S, _AVERAGE_S = 0.15, 0.5, 1.0
# A suspicion from a turn, or from scans that may be older than their times say, is only cleared
# after turning, too: while driving straight such scans look right.
_CLEARS_DEG, _CLEARS_DEG_S = 30.0, 10.0
# Normal drift of the lidars against the heading sensor within a while, and as a share of the turn;
# with more, odometry is following a lidar that was turned.
_WHILE_S, _SAMPLE_S, _DRIFT_DEG, _DRIFT_SHARE = 10.0, 0.5, 0.5, 0.02
_REST_S = 0.3  # without a piece for this long, a lidar's average does not count


@dataclass(frozen=True)
class Stand:
    """Data of one piece: the chair's pose by odometry, and the heading by the piece."""

    time_s: float
    lidar: int
    """See Piece."""
    x_m: float
    y_m: float
    heading_rad: float
    yaw_deg_s: float
    """By the heading sensor."""
    error_rad: float
    """The heading by this piece alone, against the sensor's."""
    off_deg: float
    """The same by all lidars, lately; see Seen.heading_off_deg."""
    matched: float
    known: bool
    """Whether there is a heading."""
    old_or_turned: bool = False
    """See turned_piece and repeated."""
    offset_deg: float = 0.0
    """Of odometry's heading against the sensor's, since the beginning."""
    sees_aside: bool = True
    """Whether surfaces tell where the chair is across its heading."""
    ahead_sigma_m: float = 0.0
    """Standard deviation of where the chair is along its heading, against the surfaces."""
    compared: Compared = NOT_COMPARED
    """What walls that several lidars see tell of them."""


class Mounting:
    """Feed it every piece; `turned` is set by a suspicion until driving clears it."""

    def __init__(self) -> None:
        self.turned = False
        self.known = False
        """Whether driving has shown that the lidars sit as configured."""
        self.lidar = 0
        """The one that most likely is turned, while `turned`."""
        self.by_walls = False
        """Whether walls have shown that it is that one."""
        self._time_s = -math.inf
        self._lately_deg = 0.0  # turned
        self._most_deg = 0.0  # largest difference in this episode
        self._before: Stand | None = None  # where the newest step began
        self._pieces: list[bool] = []  # since then: which tell where it is
        self._ahead_m = self._aside_m = 0.0  # since the start, a suspicion, or _CLEARS_M
        self._slips_m = [0.0, 0.0]  # to the left, to the right
        self._errors: dict[int, tuple[float, float]] = {}  # deg, when
        self._misfits: dict[int, float] = {}  # by lidar
        self._off_since_s: float | None = None
        self._to_turn_deg = 0.0  # still
        self._turned_deg = 0.0  # in all
        self._offsets: deque[tuple[float, float, float]] = deque()  # s; deg; deg turned until then

    @property
    def sigma_rad(self) -> float:
        """Standard deviation of the lidars' directions on the chair."""
        if self.known:
            return math.radians(_SIGMA_DEG)
        return math.radians(_TURNED_DEG if self.turned else _NOT_KNOWN_DEG)

    def judge(self, stand: Stand) -> bool:
        """See `turned`."""
        if stand.time_s - self._time_s > _UNSEEN_S:
            self._forget_straight()
        usable = stand.known and stand.matched >= _MATCHED
        straight = abs(stand.yaw_deg_s) < _STRAIGHT_DEG_S
        misfit = 1.0 - stand.matched + abs(math.degrees(stand.error_rad))
        before = self._misfits.get(stand.lidar, misfit)
        self._misfits[stand.lidar] = before + _MISFIT * (misfit - before)
        off_deg = max(abs(stand.off_deg), abs(math.degrees(stand.error_rad)) - _PIECE_DEG)
        self._most_deg = max(self._most_deg, off_deg) if off_deg > _SETTLED_DEG else off_deg
        dt_s, self._time_s = min(stand.time_s - self._time_s, _TURNED_S), stand.time_s
        self._lately_deg *= math.exp(-dt_s / _TURNED_S)
        self._lately_deg += abs(stand.yaw_deg_s) * dt_s
        self._turned_deg += abs(stand.yaw_deg_s) * max(0.0, dt_s)
        jump_deg = _JUMP_DEG + _JUMP_SHARE * self._lately_deg
        if usable and off_deg > jump_deg and self._most_deg < _MOST_DEG:
            self._suspect(straight)
        if self._has_drifted(stand, usable):
            self._suspect(straight)
        if stand.known and stand.old_or_turned:
            self._suspect(False)
        if usable and stand.compared.sure:
            self._suspect(straight)
        if usable and self._lately_deg < _STRAIGHT_DEG_S * _TURNED_S and self._is_off(stand):
            self._suspect(straight)
        if stand.compared.turned is not None:
            self.lidar, self.by_walls = stand.compared.turned, True
        if usable and abs(stand.yaw_deg_s) > _CLEARS_DEG_S:
            self._to_turn_deg = max(0.0, self._to_turn_deg - abs(stand.yaw_deg_s) * dt_s)
        self._pieces.append(usable and stand.sees_aside)
        straight = straight and stand.known
        since = self._before if straight else None
        if since is None or stand.time_s >= since.time_s + _STEP_S:
            if since is not None and 2 * sum(self._pieces) >= len(self._pieces):
                self._step(since, stand)
            self._before, self._pieces = stand if straight else None, []
        return self.turned

    def _has_drifted(self, stand: Stand, usable: bool) -> bool:
        if not stand.known or self._most_deg >= _MOST_DEG:
            self._offsets.clear()
            return False
        while self._offsets and self._offsets[0][0] < stand.time_s - _WHILE_S:
            self._offsets.popleft()
        if not self._offsets or stand.time_s - self._offsets[-1][0] >= _SAMPLE_S:
            self._offsets.append((stand.time_s, stand.offset_deg, self._turned_deg))
        drifted = usable and any(
            abs(stand.offset_deg - deg)
            > _DRIFT_DEG + _DRIFT_SHARE * (self._turned_deg - turned_deg)
            for _, deg, turned_deg in self._offsets
        )
        if drifted:
            self._offsets.clear()
        return drifted

    def _suspect(self, straight: bool) -> None:
        if not self.turned:
            self.lidar = max(self._misfits, key=lambda lidar: self._misfits[lidar])
            self.by_walls = False
        self.turned = True
        if not straight:
            self._to_turn_deg = _CLEARS_DEG
        self._forget_straight()

    def _forget_straight(self) -> None:
        self.known = False
        self._ahead_m = self._aside_m = 0.0
        self._slips_m = [0.0, 0.0]

    def _is_off(self, stand: Stand) -> bool:
        """Whether a lidar's heading differs for a while from the sensor's or another's."""
        average, at_s = self._errors.get(stand.lidar, (0.0, stand.time_s))
        share = 1.0 - math.exp(-(stand.time_s - at_s) / _AVERAGE_S)
        average += (math.degrees(stand.error_rad) - average) * share
        self._errors[stand.lidar] = average, stand.time_s
        recent = [deg for deg, at_s in self._errors.values() if at_s > stand.time_s - _REST_S]
        if stand.compared.agree or max(0.0, *recent) - min(0.0, *recent) < _OFF_DEG:
            self._off_since_s = None
        elif self._off_since_s is None:
            self._off_since_s = stand.time_s
        return self._off_since_s is not None and stand.time_s - self._off_since_s >= _OFF_S

    def _step(self, before: Stand, stand: Stand) -> None:
        dx, dy = stand.x_m - before.x_m, stand.y_m - before.y_m
        angle = 0.5 * (before.heading_rad + stand.heading_rad)
        ahead = math.cos(angle) * dx + math.sin(angle) * dy
        if abs(ahead) < _STEP_M:
            return
        aside = math.copysign(1.0, ahead) * (math.cos(angle) * dy - math.sin(angle) * dx)
        self._ahead_m += abs(ahead)
        self._aside_m += aside
        # Else doors are remembered where walls are, and the chair slips between them.
        sides = (1.0, -1.0) if stand.ahead_sigma_m < _SMEARED_M else ()
        for side, sign in enumerate(sides):
            more_m = min(sign * aside - _ALLOWED * abs(ahead), _MOST_M)
            self._slips_m[side] = max(0.0, self._slips_m[side] + more_m)
        right = abs(self._aside_m) < _ALLOWED * self._ahead_m and stand.compared.turned is None
        if max(self._slips_m) > _SLIPS_M:
            self._suspect(True)
        elif not self.turned:
            self.known = self.known or (right and self._ahead_m >= _KNOWN_M)
        elif self._ahead_m >= _CLEARS_M:
            self.known = right and self._off_since_s is None and self._to_turn_deg == 0.0
            self.turned = not self.known
            self._ahead_m = self._aside_m = 0.0
