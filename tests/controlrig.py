"""The host's Control with a board and a clock that the test sets."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Bypass, Clearance, Command
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.config.settings import Config, DriverConfig
from gazechair.driving.control import Control
from gazelink import codes
from gazesim.board_limits import LIMITS

QUIET = BoardState(0, 0, 0, 0, 0, 0, 90.0, 0, 12, 0, 0, 0, 0.0)


class FakeLink:
    def __init__(self) -> None:
        self.now: BoardState | None = QUIET
        self.statistics: BoardStats | None = None
        self.who: BoardId | None = BoardId("fake", "0.2.0", False, 1, 2, LIMITS)
        self.sent: list[tuple[Any, ...]] = []

    def command(self, command: Command) -> None:
        self.sent.append(("command", command.verb, command.mode, command.owner))

    def order(self, action: int, owner: int) -> None:
        self.sent.append(("order", action, owner))

    def clearance(self, clearance: Clearance) -> None:
        self.sent.append(("clearance", clearance))

    def state(self) -> BoardState | None:
        return self.now

    def stats(self) -> BoardStats | None:
        return self.statistics

    def bypass(self, bypass: Bypass | None) -> None:
        self.sent.append(("bypass", bypass))

    def board(self) -> BoardId | None:
        return self.who

    def take(self) -> list[tuple[Any, ...]]:
        sent, self.sent = self.sent, []
        return sent


class Rig:
    def __init__(self) -> None:
        self.now_s = 10.0
        self.link = FakeLink()
        self.parts = HealthRegistry(lambda: self.now_s)
        for name in ("board", "lidar", "camera"):
            self.parts.part(name).set(OK)
        config = Config(driver=DriverConfig(mode="continuous", dwell_ms=700))
        self.picture_age_s: float | None = None
        self.control = Control(
            config, self.link, self.parts, lambda: self.picture_age_s, lambda: self.now_s
        )
        self.control.update()
        self.page = self.control.connect("driver")

    def say(self, **message: Any) -> list[dict[str, Any]]:
        return self.control.receive(self.page, message)

    def board(self, **changes: Any) -> None:
        self.link.now = replace(QUIET, **changes)
        self.control.update()

    def look(self) -> dict[str, Any]:
        return self.control.snapshot(self.page)

    def arm(self) -> None:
        assert self.say(k="arm", token=self.look()["token"]) == []
        self.board(state=codes.ARMED)
        self.link.take()

    def forward(self, edge: int = 1) -> list[dict[str, Any]]:
        token = self.look()["token"]
        return self.say(k="cmd", verb="forward", mode="continuous", edge=edge, token=token)
