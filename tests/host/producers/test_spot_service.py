"""Why a ride to a spot in the picture has ended, by its service."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gazechair.base.health import Health
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.driving.mode_context import ModeContext, ModeOutput
from gazechair.producers import exchange
from gazechair.producers.contract import CHANGED, Output
from gazechair.producers.places import Target
from gazechair.producers.service import STOPPED, child_setup
from gazechair.producers.spot_service import SpotService
from gazelink.settings_table import TABLE

SEES = dict.fromkeys(("forward", "backward", "left", "right"), "seen")
SETTINGS = {row[0]: row[1] for row in TABLE}
LIDARS = (LidarConfig(kind="s2", port="/nowhere"),)


class Chair:
    """Its own port; it drives to a spot. `override`: the board's, of the press that has ended."""

    def __init__(self, folder: Path) -> None:
        self.now_s, self.armed, self.override = 100.0, True, ""
        self.tiles = {"go-look": Target("Ga waar ik kijk", "look", {}, "Go where I look")}
        self._mode, self._press = "", 0
        setup = child_setup(FootprintConfig(), folder, folder)
        health = Health("mode look")
        self.service = SpotService(
            "look", LIDARS, setup, health, lambda: self.tiles, lambda: self.now_s
        )
        self.service.connect(self, lambda: SETTINGS, lambda: self.override)  # type: ignore[arg-type]
        self.service.look()
        self._says(0, Output(None))
        self.looks()
        self._says(0, Output(None, "ready"), ask=1)
        self._mode, self._press = self.service.spot()["mode"], 1  # type: ignore[index]
        self._tick()
        self._says(1, Output((200, 0), "drives"))
        self._tick()
        assert self.service.rides

    def offer_mode(self, mode: str, tile: dict[str, Any] | None) -> None: ...

    def mode_output(self, mode: str, number: int, output: ModeOutput, *_more: object) -> None: ...

    def mode_context(self) -> ModeContext:
        nothing = dict.fromkeys(SEES)
        return ModeContext(self._mode, self._press, self.now_s, self.armed, 0.0, 0.0, nothing, SEES)

    def _says(self, press: int, sent: Output, ask: int = 0) -> None:
        self.service._on_data(exchange.pack(self.now_s, press, sent, ask))

    def _tick(self) -> None:
        self.service.tick()
        self.now_s += 0.02

    def looks(self) -> None:
        """At a spot."""
        assert self.service.choose("go-look", (0.5, 0.8), self.now_s)

    def goes_back(self) -> None:
        """*Terug*."""
        assert self.service.choose("go-look", None, self.now_s)

    def is_disarmed(self) -> None:
        self.armed = False

    def is_overruled(self) -> None:
        self.armed, self.override = False, "supervision_lost"

    def is_withdrawn(self) -> None:
        """The driver's permission."""
        self.tiles = {}
        self.service.look()

    @property
    def reason(self) -> str:
        """Of the end of the ride, once the board has ended its press."""
        self._mode = ""
        self._tick()
        news = self.service.news()
        assert news is not None
        assert news["state"] == "ended"
        return str(news["reason"])


@pytest.mark.parametrize(
    ("ends", "reason"),
    [
        (Chair.goes_back, STOPPED),
        (Chair.looks, STOPPED),
        (Chair.is_disarmed, STOPPED),
        (Chair.is_overruled, "supervision_lost"),
        (Chair.is_withdrawn, CHANGED),
    ],
)
def test_who_stops_it_is_not_told_that_it_is_impossible(
    tmp_path: Path, ends: Callable[[Chair], None], reason: str
) -> None:
    chair = Chair(tmp_path)
    ends(chair)
    assert chair.reason == reason
