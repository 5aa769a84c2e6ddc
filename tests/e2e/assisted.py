"""The whole chair in virtual time with assist, its process included."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from gazechair.assist.child import Advisor
from gazechair.assist.service import AssistService
from gazechair.base.health import Health
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.inbox.inbox import HalfTurn, pack_motion, pack_scan
from gazechair.sensing.inbox.motion import Motion
from gazesim.lockstep_chair import Lockstep
from gazesim.rooms import Room
from gazesim.world import LIDAR_HEIGHT_M, LIDAR_X_M

_LIDAR = LidarConfig(kind="s2", x_m=LIDAR_X_M, mask=((122.0, -122.0),))
_DECIDES_MS = 50
_BEAMS = 400  # of half a turn


class VirtualAssist(AssistService):
    """Its child is an Advisor in this process. `runs` False: the child is stopped, or dead."""

    def __init__(self) -> None:
        self.on = True
        super().__init__((_LIDAR,), FootprintConfig(), lambda: Health("assist"), lambda: self.on)
        argument = {"lidars": [asdict(_LIDAR)], "footprint": asdict(FootprintConfig())}
        self.advisor = Advisor(json.loads(json.dumps(argument)))
        self.runs = True

    def _supervise(self, module: str, part: str, more: Mapping[str, Any], **options: Any) -> None:
        advisor = self.advisor

        class Child:
            def send(self, message: bytes) -> None:
                advisor.take_message(message)

            def stop(self) -> None:
                pass

        self._supervisor = Child()  # type: ignore[assignment]

    def child_says(self, now_s: float) -> None:
        """Its child's next record."""
        if self.runs:
            self._on_data(json.dumps(self.advisor.report(now_s)).encode())


class Assisted(Lockstep):
    """`assist` steers while the driver's page holds Vooruit."""

    def __init__(self, room: str | Room) -> None:
        super().__init__(room)
        self.assist = VirtualAssist()
        self._half = 0
        self._told: tuple[Any, Any] = (None, None)
        host = self.host
        assert host is not None
        host.control._steer = self.assist.steer
        on_zone = host.link.on_zone
        host.link.on_zone = lambda zone: (on_zone(zone), self.assist.zone(zone))[0]
        self.watchers.append(self._act)

    def _act(self) -> None:
        host, now_s = self.host, self.now_s()
        if host is None:
            return
        clearance, state = host.control._clearance, host.link.state()
        if clearance is not self._told[0] and clearance is not None:
            self.assist.clearance(clearance)
        if state is not self._told[1] and state is not None:
            heading = state.heading_deg if state.heading_known else None
            outputs = state.linear_permille, state.turn_permille
            self.assist.advisor.take(
                pack_motion(Motion(state.received_s, heading, *outputs)), now_s
            )
        self._told = clearance, state
        if self.now_ms % _DECIDES_MS == 0:
            self.assist.advisor.take(self._half_turn(now_s), now_s)
            self.assist.child_says(now_s)

    def _half_turn(self, now_s: float) -> bytes:
        self._half = 1 - self._half
        angles = np.linspace(-180.0, 0.0, _BEAMS, endpoint=False) + 180.0 * self._half
        x, y, heading = self.world.pose
        x += LIDAR_X_M * np.cos(np.radians(heading))
        y += LIDAR_X_M * np.sin(np.radians(heading))
        ranges = self.world.room.cast(x, y, np.radians(angles + heading), LIDAR_HEIGHT_M)
        seen = np.where(np.isfinite(ranges), ranges, 0.0)
        return pack_scan(HalfTurn(0, angles, seen, now_s - 0.002, now_s))
