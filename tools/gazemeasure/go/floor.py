"""Measures "go where I look" by the truth: random cameras, calibrations and gaze; then drives.

A tablet 29 cm wide, 60 cm before the eyes, shows the whole picture. Gaze: 1 degree in each axis,
either as noise (new every 0.2 s; a dwell of 1 s takes the mean) or as an offset that stays for the
whole dwell. With a magnifier, a second dwell on the part around the first, three times as large.
With one switch, the middle of the page's cell that contains the intended spot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint
from gazechair.going.costmap import costmap_of
from gazechair.going.look import goal, seen_from_here
from gazechair.going.mission import Mission
from gazechair.going.plan import NoPath, Planner, Pose
from gazechair.picture.floor import FARTHEST_M, FloorCamera, NoSpot, gaze_px
from gazechair.sensing.lidar.scan import to_chair
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazelink.settings_table import PROFILES
from gazemeasure.go.line import calibrated, random_eye
from gazemeasure.go.rig import Go
from gazemeasure.report import Report, percentile
from gazesim import random_rooms
from gazesim.floor_view import Eye
from gazesim.rooms import Room

TABLET_M, GAZE_DEG = 0.29, 1.0
_NOISE_S, _DWELL_S, _RATE_HZ = 0.2, 1.0, 60.0
_MAGNIFIED = 3.0
SWITCHED = (16, 12)
"""Columns, and cells of each, of web/spot_scan.js."""
_SPOTS_M = ((1.3, 3.0), (-0.9, 0.9))  # ahead, to the side
_SCANS = 3
_LIMIT_S = 60.0
NOISE, SHIFT, MAGNIFIED = "noise", "shift", "shift, magnifier"
SWITCH = "one switch"


@dataclass(frozen=True)
class Went:
    """One look and drive. `off_m`: from the intended spot to the axle at its stop."""

    refused: str
    off_m: float
    collisions: int


def measure(report: Report, quick: bool) -> None:
    """Add the rows."""
    random = np.random.default_rng(5)
    cameras = [(eye, calibrated(eye, random)) for eye in _eyes(random, 20 if quick else 300)]
    good = [(eye, camera) for eye, camera in cameras if camera is not None]
    report.add("look: calibrations refused", 100.0 * (1.0 - len(good) / len(cameras)), "%")
    for kind, limit in ((NOISE, 0.2), (SHIFT, None), (MAGNIFIED, 0.2), (SWITCH, 0.2)):
        looks = [off_m(eye, camera, kind, random) for eye, camera in good for _ in range(20)]
        seen = [off for off in looks if off is not None]
        refused = 100.0 * (1.0 - len(seen) / len(looks))
        by = kind if kind == SWITCH else f"gaze ({kind})"
        report.add(f"look: spot found by {by}, median", percentile(seen, 0.5), "m", limit)
        report.add("  95 %", percentile(seen, 0.95), "m")
        report.add("  refused as too far or unsure", refused, "%")
    # A shift that stays for the dwell is not averaged out: shown before Ga, or looked at magnified.
    for kind, limit in ((NOISE, 0.2), (SHIFT, None), (MAGNIFIED, 0.2)):
        went = [go(seed, kind) for seed in range(3 if quick else 60)]
        drove = [one for one in went if not one.refused]
        refused = 100.0 * (1.0 - len(drove) / len(went))
        report.add(f"look: spots refused ({kind})", refused, f"% of {len(went)}")
        offs = [one.off_m for one in drove]
        report.add("  stopped off the spot meant, median", percentile(offs, 0.5), "m", limit)
        report.add("  95 %", percentile(offs, 0.95), "m")
        report.add("  collisions", sum(one.collisions for one in drove), "", 0.0)
    report.note(f"(look: {len(good)} cameras; drives without a map, 5 profiles)")


def _eyes(random: np.random.Generator, count: int) -> list[Eye]:
    return [random_eye(random) for _ in range(count)]


def _shift_px(eye: Eye, kind: str, random: np.random.Generator) -> FloatArray:
    """Error of the dwell's mean, pixels of the camera's picture."""
    sigma_px = gaze_px(GAZE_DEG, eye.width_px, TABLET_M)
    if kind == NOISE:
        fade = math.exp(-1.0 / (_NOISE_S * _RATE_HZ))
        samples = [random.standard_normal(2)]
        for _ in range(round(_DWELL_S * _RATE_HZ) - 1):
            fresh = random.standard_normal(2)
            samples.append(fade * samples[-1] + math.sqrt(1.0 - fade**2) * fresh)
        return np.asarray(sigma_px * np.mean(samples, axis=0))
    shift = sigma_px * random.standard_normal(2)
    return np.asarray(shift / (_MAGNIFIED if kind == MAGNIFIED else 1.0))


def _spot(
    eye: Eye, camera: FloorCamera, meant_m: FloatArray, kind: str, random: np.random.Generator
) -> tuple[float, float] | str:
    """The spot that the host computes for the look, or the reason for none."""
    pixel = np.array(eye.pixel(*meant_m.tolist()))
    if kind == SWITCH:
        top = np.array((0.0, camera.pixels(np.array(((FARTHEST_M, 0.0),)))[0, 1]))
        cell = (np.array((eye.width_px, eye.height_px)) - top) / SWITCHED
        pixel = top + cell * (np.floor((pixel - top) / cell) + 0.5)
    else:
        pixel += _shift_px(eye, kind, random)
    sigma_px = gaze_px(GAZE_DEG, eye.width_px, TABLET_M)
    found = camera.spot((float(pixel[0]), float(pixel[1])), sigma_px / 2.0)
    return found.reason if isinstance(found, NoSpot) else (found.x_m, found.y_m)


def _meant(eye: Eye, random: np.random.Generator) -> FloatArray:
    """A random spot that the picture shows, with some margin."""
    while True:
        spot = np.array([random.uniform(*bounds) for bounds in _SPOTS_M])
        share = np.array(eye.pixel(*spot.tolist())) / (eye.width_px, eye.height_px)
        if (share > 0.06).all() and (share < 0.94).all():
            return spot


def off_m(eye: Eye, camera: FloorCamera, kind: str, random: np.random.Generator) -> float | None:
    meant = _meant(eye, random)
    found = _spot(eye, camera, meant, kind, random)
    return None if isinstance(found, str) else float(np.hypot(*(meant - found)))


class LookGo(Go):
    """A chair that knows only its lidars' view from where it stands."""

    def without_map(self, footprint: Footprint) -> tuple[Mission, list[KeyScan]]:
        """A mission on the present view instead of a map."""
        scans = []
        for _ in range(_SCANS):
            self.run_ms(100)
            x, y, heading_deg = self.pose
            pose = np.array((x, y, math.radians(heading_deg)))
            views = [
                to_chair(eye.scan(self.now_ms / 1000.0), eye.mount.pose, eye.mount.mask, blind)
                for eye, blind in zip(self._eyes, self._blindness, strict=True)
            ]
            points = np.concatenate([view.points_m for view in views])
            origins = [np.tile(view.origin_m, (len(view.points_m), 1)) for view in views]
            scans.append(
                KeyScan(pose, points, np.concatenate(origins), pose[2], self.now_ms / 1000.0, 0.0)
            )
        costmap = costmap_of(seen_from_here(scans, footprint), footprint)
        self.mission = Mission(costmap, Planner(costmap, True), self.numbers, footprint)
        return self.mission, scans


def go(seed: int, kind: str = NOISE) -> Went:
    """Look at a free spot on the floor of a random room, and drive there."""
    random = np.random.default_rng((seed, 71))
    camera, meant = None, None
    while camera is None:
        eye = random_eye(random)
        camera = calibrated(eye, random)
    while meant is None:
        room = random_rooms.task("room", int(random.integers(1 << 30))).room
        x, y, heading_deg = room.start
        start = (x, y, math.radians(heading_deg))
        meant = _free_spot(room, eye, start, random)
    profile = PROFILES[seed % len(PROFILES)]
    chair = LookGo(room, seen_from_here(_bare(), Footprint()), start, profile, seed=seed)
    mission, scans = chair.without_map(Footprint())
    found = _spot(eye, camera, meant, kind, random)
    if isinstance(found, str):
        return Went(found, 0.0, 0)
    grid = seen_from_here(scans, Footprint())
    at = goal(found, start, grid, mission.costmap)
    if isinstance(at, NoPath):
        return Went(at.reason, 0.0, 0)
    outcome = chair.go(at, _LIMIT_S)
    c, s = math.cos(start[2]), math.sin(start[2])
    true = (start[0] + c * meant[0] - s * meant[1], start[1] + s * meant[0] + c * meant[1])
    return Went("", math.dist(chair.pose[:2], true), outcome.collisions)


def _bare() -> list[KeyScan]:
    """Two scans without anything near: the chair's first view."""
    points = np.array(((5.0, 0.0), (0.0, 5.0), (-5.0, 0.0), (0.0, -5.0)))
    return [KeyScan(np.zeros(3), points, np.zeros((4, 2)), 0.0, 0.1 * k, 0.0) for k in range(2)]


def _free_spot(room: Room, eye: Eye, start: Pose, random: np.random.Generator) -> FloatArray | None:
    """A visible spot, reached by a turn and straight on, where the chair has room by the truth."""
    x, y, turn = start
    c, s = math.cos(turn), math.sin(turn)
    for _ in range(40):
        meant = _meant(eye, random)
        steps = np.linspace(0.0, 1.0, 12)[:, None] * meant
        along = math.degrees(turn) + math.degrees(math.atan2(meant[1], meant[0]))
        path = [(x + c * a - s * b, y + s * a + c * b) for a, b in steps]
        if min(room.clearance_m(px, py, along) for px, py in path) > 0.08:
            return meant
    return None
