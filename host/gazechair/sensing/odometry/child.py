"""Odometry's child process: reads its inbox, and sends the daemon each estimate."""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, NoReturn

import numpy as np

from gazechair.base.child_main import child_main
from gazechair.base.child_records import RecordWriter
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.lidar.scan import Pose, in_arcs
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.points import Piece

_OLD_S = 0.5  # older data in the inbox is discarded
_PULSE_S = 0.5
_TURN_S = 0.1


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


def run(argument: Mapping[str, Any], out: RecordWriter) -> NoReturn:
    """Serve until the parent closes the pipe (BrokenPipeError)."""
    lidars = Lidars.of(argument["lidars"])
    reader = socket.socket(fileno=argument["fd"])
    reader.setblocking(False)
    odometry = Odometry(time.monotonic_ns() // 1_000_000)  # no track of a process before this one
    pulse_s = 0.0
    while True:
        now_s = time.monotonic()
        if now_s >= pulse_s:  # alive, though nothing is measured
            out.data(b"null")
            pulse_s = now_s + _PULSE_S
        if not select.select([reader], [], [], _PULSE_S)[0]:
            continue
        message = inbox.unpack(reader.recv(inbox.LONGEST))
        oldest_s = time.monotonic() - _OLD_S
        if isinstance(message, Motion) and message.time_s > oldest_s:
            odometry.motion(message)
        elif isinstance(message, HalfTurn) and message.last_s > oldest_s:
            piece = lidars.piece(message)
            estimate = odometry.piece(piece) if piece is not None else None
            if estimate is not None:
                out.data(json.dumps(asdict(estimate)).encode())
                pulse_s = time.monotonic() + _PULSE_S


def main() -> int:
    """Entry of `python -m gazechair.sensing.odometry.child JSON`: lidars, fd."""
    return child_main(run)


if __name__ == "__main__":
    sys.exit(main())
