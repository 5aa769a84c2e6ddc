"""Which steps of the first drive are done, and what blocks each: from facts alone. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazechair.base import health as states
from gazechair.base.health import HealthState
from gazechair.board.board_commands import Clearance
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.config.settings import LidarConfig
from gazechair.first_drive.floor_marks import FloorMarks
from gazechair.first_drive.record import Record, fitted_as
from gazelink import VERSION, codes
from gazelink.messages import CLEAR_FAR
from gazelink.settings_table import PROFILES, TABLE, index_of

MOVES = ("relay", "tune", "turn")
"""Only while a caretaker holds the step's button."""
STEPS = (
    *("versions", "mask", "distance", "neutral", "heading", "profile"),
    *(*MOVES, "camera", "person", "practice"),
)
NEUTRALS = ("neutral_linear_count", "neutral_turn_count")
NEAR_MM = 50  # tape and lidar may differ by this
_NEAR_DEG = 2.0
_CALIBRATED = 3
_RELAY_FAULTS = 1 << codes.RELAY_OPEN | 1 << codes.RELAY_STUCK | 1 << codes.RELAY_UNEXPECTED


@dataclass(frozen=True)
class Facts:
    """The host's knowledge at one moment."""

    state: BoardState | None
    stats: BoardStats | None
    board: BoardId | None
    parts: dict[str, HealthState]
    clearance: Clearance | None
    lidars: tuple[LidarConfig, ...]
    """As configured, without disabled ones."""
    record: Record
    person: str
    """Name of the chosen profile; "" while nobody has chosen any."""
    marks: FloorMarks | None
    """None: no camera is configured, and there is no such step."""

    def rows(self) -> list[dict[str, Any]]:
        """{"step", "done", "refused": a reason key or "", ...what the step shows}, in order."""
        return [
            {"step": step, "refused": self.refused(step), **getattr(self, f"_{step}")()}
            for step in STEPS
            if step != "camera" or self.marks is not None
        ]

    def refused(self, step: str) -> str:
        """Why `step` cannot begin, a key of the string tables; "" when it can."""
        drives = self.state is not None and self.state.state != codes.DISARMED
        if step == "mask" and drives:
            return "setting_while_armed"
        if step in ("mask", "distance"):
            lidar = self.parts.get("lidar")
            known = lidar is not None and lidar.state != states.LOST and self.lidars
            return "" if known else "lidar_lost"
        if step == "camera":
            return "setting_while_armed" if drives else self._unseen()
        if step in ("versions", "person", "practice"):
            return ""
        state, board = self.state, self.parts.get("board")
        if state is None:
            reason = "" if board is None else board.reason
            return reason if reason not in ("", "ok") else "not_connected"
        if drives:
            return "setting_while_armed"
        if step == "neutral" and state.faults >> codes.WIPER & 1:
            return "wiper"
        if step == "relay" and not state.relay_checked:
            return "first_no_relay"
        if step in MOVES and state.arm_reason:
            return state.arm_reason_name
        return ""

    def _versions(self) -> dict[str, Any]:
        own = ".".join(map(str, VERSION))
        board = None if self.board is None else f"{self.board.name} {self.board.version}"
        return {"done": self.board is not None, "host": own, "board": board}

    def _mask(self) -> dict[str, Any]:
        known = [self.record.has_mask_of(one) or one.mask for one in self.lidars]
        arcs = [[list(arc) for arc in one.mask] for one in self.record.masked(self.lidars)]
        return {"done": bool(known) and all(known), "arcs": arcs}

    def _distance(self) -> dict[str, Any]:
        found = self.record.get("distance") or {}
        same = found.get("lidars") == [fitted_as(one) for one in self.record.masked(self.lidars)]
        measured, seen = found.get("measured_mm"), found.get("seen_mm")
        near = measured is not None and abs(measured - seen) <= NEAR_MM
        now = None if self.clearance is None else self.clearance.forward_mm
        return {
            "done": bool(same and near),
            "seen_mm": None if now == CLEAR_FAR else now,
            "found": [measured, seen] if same and measured is not None else None,
        }

    def _neutral(self) -> dict[str, Any]:
        counts = self._settings(*NEUTRALS)
        defaults = [TABLE[index_of(name)][1] for name in NEUTRALS]
        measured = counts != defaults or counts == self.record.get("neutral")
        stored = self.state is not None and not self.state.faults >> codes.CALIBRATION & 1
        return {"done": counts is not None and measured and stored, "counts": counts}

    def _heading(self) -> dict[str, Any]:
        status = 0 if self.stats is None else self.stats.counters["imu_status"]
        trusted, gyro, accelerometer = status & 1, status >> 4 & 3, status >> 2 & 3
        done = bool(trusted) and gyro == accelerometer == _CALIBRATED
        degrees = None
        if self.state is not None and self.state.heading_known:
            degrees = round(self.state.heading_deg)
        return {"done": done, "gyro": gyro, "accelerometer": accelerometer, "degrees": degrees}

    def _profile(self) -> dict[str, Any]:
        profile = None if self.state is None else self.state.profile
        done = profile is not None and (self._tuned() or profile == self.record.get("profile"))
        return {"done": done, "profile": profile, "choices": PROFILES}

    def _relay(self) -> dict[str, Any]:
        state = self.state
        good = state is not None and state.relay_checked and not state.faults & _RELAY_FAULTS
        return {"done": good and bool(self.record.get("relay"))}

    def _tune(self) -> dict[str, Any]:
        profile = None if self.state is None else self.state.profile
        return {"done": self._tuned(), "profile": profile}

    def _turn(self) -> dict[str, Any]:
        found, state = self.record.get("turn") or {}, self.state
        profile = None if state is None else [state.profile, state.tuned]
        same = profile is not None and found.get("profile") == profile
        turned = found.get("turned_deg") if same else None
        wanted = found.get("wanted_deg") if same else None
        near = turned and all(abs(abs(one) - wanted) <= _NEAR_DEG for one in turned)
        return {"done": bool(near), "turned_deg": turned, "wanted_deg": wanted}

    def _camera(self) -> dict[str, Any]:
        return {} if self.marks is None else self.marks.row()

    def _unseen(self) -> str:
        if self.marks is not None and not self.marks.readable:
            return "first_no_pillow"
        camera = self.parts.get("camera")
        sees = self.marks is not None and camera is not None and camera.state != states.LOST
        return "" if self.marks and sees and self.marks.size_px() else "camera_lost"

    def _person(self) -> dict[str, Any]:
        return {"done": self.person != "", "name": self.person}

    def _practice(self) -> dict[str, Any]:
        return {"done": bool(self.record.get("drove"))}

    def _tuned(self) -> bool:
        return self.state is not None and self.state.tuned is True

    def _settings(self, *names: str) -> list[int] | None:
        known = {} if self.state is None else self.state.settings
        return [known[name] for name in names] if all(name in known for name in names) else None
