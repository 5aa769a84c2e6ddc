"""Draws a recorded drive from above, as the simulated chair drives it: path, scans, stops.

The heading is the one that the board measured; the distance is the model's, because the chair does
not measure it. So the path is an estimate, and is labelled so.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gazechair.base.footprint import DEFAULT_CORNERS
from gazechair.base.output_file import write_output
from gazechair.blackbox.reader import Line
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazesim.chair import Chair

_STEP_S = 0.01
_GAP_S = 0.5  # without a state for longer, the chair is assumed to stand
_SCAN_OLD_NS = 10**9
_EDGE_M = 0.5
_LETTERS = 45.0  # high, across the picture

Point = tuple[float, float]


@dataclass(frozen=True)
class Event:
    """Something to mark in the picture."""

    at_ns: int
    text: str
    pose: tuple[float, float, float]
    """x, y, heading in degrees: metres from the start, x along the heading at the start."""
    scan: tuple[Point, ...]
    """What the lidars saw, in the same frame."""


@dataclass
class Drive:
    """The data of the picture."""

    path: list[Point] = field(default_factory=lambda: [(0.0, 0.0)])
    events: list[Event] = field(default_factory=list)


class Follower:
    """Drives the model with the board's outputs."""

    def __init__(self) -> None:
        self.drive = Drive()
        self._chair = Chair()
        self._north_deg: float | None = None
        self._last_ns = 0
        self._scans: dict[str, tuple[int, Any]] = {}
        self._places: dict[str, Any] = {}
        self._shown = ""

    def take(self, line: Line) -> None:
        """The next message."""
        if line.topic == "/board/state":
            self._state(line.at_ns, line.message)
        elif line.topic == "/board/stats":
            profile = line.message.profile & 0x7F
            if profile < len(PROFILES) and PROFILES[profile] != self._chair.profile:
                self._chair.set_profile(PROFILES[profile])
        elif line.topic.startswith("/scan/"):
            self._scans[line.topic.removeprefix("/scan/")] = (line.at_ns, line.message)
        elif line.topic == "/tf_static":
            for row in line.message.transforms:
                self._places[row.child_frame_id] = row.transform

    def end(self) -> None:
        """No more messages follow."""
        if self._last_ns:
            self._tell(self._last_ns, "end")

    def _state(self, at_ns: int, state: Any) -> None:
        chair = self._chair
        seconds = min((at_ns - self._last_ns) / 1e9, _GAP_S) if self._last_ns else 0.0
        self._last_ns = at_ns
        stick = (state.linear_permille / 1000, state.turn_permille / 1000)
        for _ in range(round(seconds / _STEP_S)):
            chair.step(_STEP_S, stick)
        if not state.faults & codes.HEADING_FAULTS:
            measured_deg = state.heading_q4_deg / 16
            if self._north_deg is None:
                self._north_deg = measured_deg
            chair.heading_deg = measured_deg - self._north_deg
        here = (chair.x_m, chair.y_m)
        if math.dist(here, self.drive.path[-1]) > 0.01:
            self.drive.path.append(here)
        names = [row[1] for row in codes.FAULTS if state.faults >> row[0] & 1]
        armed = state.status & 15 == codes.ARMED
        if not names and state.override:
            names = [codes.reason_name(state.override)]
        shown = ", ".join(names)
        if shown != self._shown:
            self._shown = shown
            if shown and (armed or len(self.drive.path) > 1):
                self._tell(at_ns, shown)

    def _tell(self, at_ns: int, text: str) -> None:
        chair = self._chair
        pose = (chair.x_m, chair.y_m, chair.heading_deg)
        seen: list[Point] = []
        for name, (scanned_ns, scan) in self._scans.items():
            place = self._places.get(name)
            if place is not None and at_ns - scanned_ns < _SCAN_OLD_NS:
                seen += [_moved(point, pose) for point in _points(scan, place)]
        self.drive.events.append(Event(at_ns, text, pose, tuple(seen)))


def follow(lines: Iterable[Line]) -> Drive:
    """The drive in these messages."""
    follower = Follower()
    for line in lines:
        follower.take(line)
    follower.end()
    return follower.drive


def draw(drive: Drive, target: Path) -> None:
    """Write it as SVG; up is the chair's heading at the start. Raises UserError."""
    outlines = [
        [_moved(corner, event.pose) for corner in DEFAULT_CORNERS] for event in drive.events
    ]
    everything = [
        *drive.path,
        *(point for event in drive.events for point in event.scan),
        *(point for outline in outlines for point in outline),
    ]
    left, right = (choose(-y for _, y in everything) for choose in (min, max))
    top, bottom = (choose(-x for x, _ in everything) for choose in (min, max))
    box = (left - _EDGE_M, top - _EDGE_M, right - left + 2 * _EDGE_M, bottom - top + 2 * _EDGE_M)
    size = box[2] / _LETTERS
    style = f'width="900" font-family="sans-serif" font-size="{_n(size)}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{" ".join(map(_n, box))}" {style}>',
        f'<rect x="{_n(box[0])}" y="{_n(box[1])}" width="100%" height="100%" fill="#fff"/>',
    ]
    for event in drive.events:
        for x, y in event.scan:
            parts.append(f'<circle cx="{_n(-y)}" cy="{_n(-x)}" r="0.015" fill="#888"/>')
    for outline in outlines:
        corners = " ".join(f"{_n(-y)},{_n(-x)}" for x, y in outline)
        parts.append(f'<polygon points="{corners}" fill="none" stroke="#36c" stroke-width="0.01"/>')
    line = " ".join(f"{_n(-y)},{_n(-x)}" for x, y in drive.path)
    parts.append(f'<polyline points="{line}" fill="none" stroke="#c33" stroke-width="0.03"/>')
    for event in drive.events:
        moment = time.strftime("%H:%M:%S", time.localtime(event.at_ns // 10**9))
        x, y, _ = event.pose
        parts.append(f'<text x="{_n(-y + size)}" y="{_n(-x)}">{moment} {event.text}</text>')
    note = "path estimated by the simulator's chair; heading as measured"
    corner = f'x="{_n(box[0] + size)}" y="{_n(box[1] + 2 * size)}"'
    parts.append(f'<text {corner} fill="#555">{note}</text></svg>')
    write_output(target, ("\n".join(parts) + "\n").encode())


def _points(scan: Any, place: Any) -> list[Point]:
    """The returns in the chair's frame."""
    q, at = place.rotation, place.translation
    found = []
    for beam, range_m in enumerate(scan.ranges):
        if math.isfinite(range_m):
            angle = scan.angle_min + beam * scan.angle_increment
            x, y = range_m * math.cos(angle), range_m * math.sin(angle)
            found.append(
                (
                    at.x + (1 - 2 * (q.y**2 + q.z**2)) * x + 2 * (q.x * q.y - q.z * q.w) * y,
                    at.y + 2 * (q.x * q.y + q.z * q.w) * x + (1 - 2 * (q.x**2 + q.z**2)) * y,
                )
            )
    return found


def _moved(point: Point, pose: tuple[float, float, float]) -> Point:
    x, y, heading_deg = pose
    cos, sin = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    return x + cos * point[0] - sin * point[1], y + sin * point[0] + cos * point[1]


def _n(number: float) -> str:
    return f"{number:.3f}"
