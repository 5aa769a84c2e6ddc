"""The whole chair in virtual time with assist, its process included."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from gazechair.assist.child import Advisor
from gazechair.assist.service import AssistService
from gazechair.base.health import Health
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.inbox.feed import Feed
from gazechair.sensing.inbox.half_turns import HalfTurns
from gazesim.lockstep_chair import Lockstep
from gazesim.producer_chair import waiting
from gazesim.rooms import Room
from gazesim.world import LIDAR_X_M

_LIDAR = LidarConfig(kind="s2", x_m=LIDAR_X_M, mask=((122.0, -122.0),))
_DECIDES_MS = 50


class VirtualAssist(AssistService):
    """Its child is an Advisor in this process. `runs` False: the child is stopped, or dead."""

    def __init__(self) -> None:
        self.on = True
        super().__init__((_LIDAR,), FootprintConfig(), lambda: Health("assist"), lambda: self.on)
        self.advisor = _advisor()
        self.runs = True
        self.newest = b""
        self.sent: list[bytes] = []
        """Every record of its child."""

    def _supervise(self, module: str, part: str, more: Mapping[str, Any], **options: Any) -> None:
        service = self

        class Child:
            def send(self, message: bytes) -> None:
                service.newest = message
                if service.runs:
                    service.advisor.take_message(message)

            def stop(self) -> None:
                pass

        self._supervisor = Child()  # type: ignore[assignment]

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of its child's life."""
        now_s = now_ms / 1000
        for datagram in waiting(self):
            if self.runs:
                self.advisor.take(datagram, now_s)
        if self.runs and now_ms % _DECIDES_MS == 0:
            self.sent.append(json.dumps(self.advisor.report(now_s)).encode())
            self._on_data(self.sent[-1])

    def starts_again(self) -> None:
        """Its child is a new process, which gets the newest message."""
        self.advisor, self.runs = _advisor(), True
        self.advisor.take_message(self.newest)


def _advisor() -> Advisor:
    argument = {"lidars": [asdict(_LIDAR)], "footprint": asdict(FootprintConfig())}
    return Advisor(json.loads(json.dumps(argument)))


class Assisted(Lockstep):
    """`assist` steers while the driver's page holds Vooruit."""

    def __init__(self, room: str | Room) -> None:
        super().__init__(room)
        self.assist = VirtualAssist()
        self._feed = Feed((self.assist.inbox_fd,))
        self._sent: tuple[Any, Any] = (None, None)
        host = self.host
        assert host is not None
        host.control._steer = self.assist.steer
        on_zone = host.link.on_zone
        host.link.on_zone = lambda zone: (on_zone(zone), self.assist.zone(zone))[0]
        host.streams[0]._tap = HalfTurns(0, (self.assist.inbox_fd,)).take
        self.watchers.append(self._act)

    def _act(self) -> None:
        host = self.host
        if host is None:
            return
        clearance, state = host.control._clearance, host.link.state()
        if clearance is not self._sent[0] and clearance is not None:
            self.assist.clearance(clearance)
        if state is not self._sent[1] and state is not None:
            self._feed.board(state)
        self._sent = clearance, state
        self.assist.one_ms(self.now_ms)
