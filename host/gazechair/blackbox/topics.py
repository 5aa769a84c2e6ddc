"""The topics of the log: which ROS message each kind of record becomes."""

from __future__ import annotations

import array
import math
import re
from collections.abc import Callable, Iterator
from typing import Any

from gazechair.base import health as states
from gazechair.blackbox import ros
from gazelink import messages

# topic, ROS name, message
TopicMessage = tuple[str, str, dict[str, Any]]

CHAIR = "chair"  # the frame of the drive axle: x forward, y to the left

_LEVELS = {states.OK: 0, states.STARTING: 1, states.DEGRADED: 1, states.LOST: 2}


def _up(at_ns: int, frame: bytes) -> Iterator[TopicMessage]:
    found = ros.from_frame(frame, at_ns)
    if found is not None:
        yield f"/host/{found[0].name}", ros.wire_type(found[0]), found[1]


def _down(at_ns: int, frame: bytes) -> Iterator[TopicMessage]:
    found = ros.from_frame(frame, at_ns)
    if found is None:
        return
    message, fields = found
    yield f"/board/{message.name}", ros.wire_type(message), fields
    if message is messages.STATE:
        # Shares of full deflection, as of a joystick: forward and left positive.
        linear, turn = fields["linear_permille"] / 1000, fields["turn_permille"] / 1000
        yield "/board/output", ros.TWIST, {"linear": _vector(x=linear), "angular": _vector(z=turn)}


def _scan(at_ns: int, scan: tuple[str, bytes]) -> Iterator[TopicMessage]:
    name, beams_mm = scan
    ranges = [mm / 1000 if mm else math.inf for mm in array.array("H", beams_mm)]
    step = 2 * math.pi / len(ranges)
    yield (
        f"/scan/{_frame(name)}",
        ros.SCAN,
        {
            "header": _header(at_ns, _frame(name)),
            "angle_min": -math.pi + step / 2,
            "angle_max": math.pi - step / 2,
            "angle_increment": step,
            "time_increment": 0.0,
            "scan_time": 0.0,
            "range_min": 0.05,
            "range_max": 65.0,
            "ranges": ranges,
            "intensities": [],
        },
    )


def _places(
    at_ns: int, lidars: list[tuple[str, float, float, float, bool]]
) -> Iterator[TopicMessage]:
    transforms = []
    for name, x_m, y_m, heading_deg, upside_down in lidars:
        half = math.radians(heading_deg) / 2
        turned = (0.0, 0.0, math.sin(half), math.cos(half))  # x, y, z, w
        if upside_down:
            turned = (math.cos(half), math.sin(half), 0.0, 0.0)
        transform = {
            "translation": {"x": x_m, "y": y_m, "z": 0.0},
            "rotation": dict(zip("xyzw", turned, strict=True)),
        }
        header = _header(at_ns, CHAIR)
        row = {"header": header, "child_frame_id": _frame(name), "transform": transform}
        transforms.append(row)
    yield "/tf_static", ros.PLACES, {"transforms": transforms}


def _motion(at_ns: int, found: dict[str, Any]) -> Iterator[TopicMessage]:
    half = math.radians(found["heading_deg"]) / 2
    x_m, y_m = found["x_m"], found["y_m"]
    twist = {
        "linear": _vector(found["speed_m_s"]) | {"y": found["sideways_m_s"]},
        "angular": _vector(z=math.radians(found["yaw_rate_deg_s"])),
    }
    yield (
        "/odometry",
        ros.ODOMETRY,
        {
            "header": _header(at_ns, f"odom_{found['track']}"),
            "child_frame_id": CHAIR,
            "pose": {
                "pose": {
                    "position": {"x": x_m, "y": y_m, "z": 0.0},
                    "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
                },
                "covariance": _place_covariance(found),
            },
            "twist": {
                "twist": twist,
                "covariance": [found["speed_sigma_m_s"] ** 2, *([0.0] * 35)],
            },
        },
    )
    values = {"age_ms": round(1000 * found["age_s"], 1), "matched": round(found["matched"], 3)}
    status = _status(int(bool(found["doubts"])), "odometry", ", ".join(found["doubts"]), values)
    yield (
        "/odometry/doubts",
        ros.DIAGNOSTICS,
        {"header": _header(at_ns), "status": [status]},
    )


def _place_covariance(found: dict[str, Any]) -> list[float]:
    """Rows of x, y, z, and rotations about them; in the frame of the pose, as in ROS."""
    turned = math.radians(found["heading_deg"])
    c, s = math.cos(turned), math.sin(turned)
    along, across = found["along_sigma_m"] ** 2, found["across_sigma_m"] ** 2
    rows = [0.0] * 36
    rows[0], rows[7] = c * c * along + s * s * across, s * s * along + c * c * across
    rows[1] = rows[6] = c * s * (along - across)
    rows[35] = math.radians(found["heading_sigma_deg"]) ** 2
    return rows


def _pose(at_ns: int, pose: tuple[str, float, float, float]) -> Iterator[TopicMessage]:
    name, x_m, y_m, heading_deg = pose
    half = math.radians(heading_deg) / 2
    transform = {
        "translation": {"x": x_m, "y": y_m, "z": 0.0},
        "rotation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
    }
    header = _header(at_ns, f"map_{_frame(name)}")
    row = {"header": header, "child_frame_id": CHAIR, "transform": transform}
    yield "/tf", ros.PLACES, {"transforms": [row]}


def _health(at_ns: int, parts: list[tuple[str, str, str, str]]) -> Iterator[TopicMessage]:
    status = [
        _status(_LEVELS[state], name, reason, {"state": state, "detail": detail})
        for name, state, reason, detail in parts
    ]
    yield "/health", ros.DIAGNOSTICS, {"header": _header(at_ns), "status": status}


def _figures(at_ns: int, figures: dict[str, float]) -> Iterator[TopicMessage]:
    status = [_status(0, "host", "", figures)]
    yield "/latency", ros.DIAGNOSTICS, {"header": _header(at_ns), "status": status}


def _picture(at_ns: int, jpeg: bytes) -> Iterator[TopicMessage]:
    header = _header(at_ns, "camera")
    yield "/picture", ros.PICTURE, {"header": header, "format": "jpeg", "data": jpeg}


def _line(at_ns: int, line: tuple[int, str, str]) -> Iterator[TopicMessage]:
    level, name, text = line
    fields = {"stamp": ros.stamp(at_ns), "level": level, "name": name, "msg": _text(text)}
    yield "/rosout", ros.LINE, {**fields, "file": "", "function": "", "line": 0}


# {kind of record: what it becomes at a wall time in ns}
_KINDS: dict[str, Callable[[int, Any], Iterator[TopicMessage]]] = {
    "up": _up,
    "down": _down,
    "scan": _scan,
    "places": _places,
    "motion": _motion,
    "pose": _pose,
    "health": _health,
    "figures": _figures,
    "picture": _picture,
    "line": _line,
}


def messages_of(kind: str, at_ns: int, payload: Any) -> Iterator[TopicMessage]:
    """The messages for a record of that kind, any number of them."""
    return _KINDS[kind](at_ns, payload)


def _status(level: int, name: str, message: str, values: dict[str, Any]) -> dict[str, Any]:
    return {
        "level": level,
        "name": name,
        "message": message,
        "hardware_id": "",
        "values": [{"key": key, "value": _text(str(value))} for key, value in values.items()],
    }


def _frame(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]", "_", name)  # as ROS requires


def _text(text: str) -> str:
    return text.encode("utf-8", "replace").decode()  # a file name may be invalid UTF-8


def _header(at_ns: int, frame_id: str = "") -> dict[str, Any]:
    return {"stamp": ros.stamp(at_ns), "frame_id": frame_id}


def _vector(x: float = 0.0, z: float = 0.0) -> dict[str, float]:
    return {"x": x, "y": 0.0, "z": z}
