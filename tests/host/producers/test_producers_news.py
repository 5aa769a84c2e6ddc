"""News of several kinds: the current motion, else the last one that ended."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gazechair.base.health import Health
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.driving.mode_context import ModeContext, ModeOutput
from gazechair.producers import exchange
from gazechair.producers.contract import Output
from gazechair.producers.places import Target
from gazechair.producers.producers import Producers
from gazechair.producers.service import ProducerService, child_setup
from gazelink.settings_table import TABLE

SEES = dict.fromkeys(("forward", "backward", "left", "right"), "seen")
SETTINGS = {row[0]: row[1] for row in TABLE}
KINDS = ("place", "person", "line")


class Chair:
    """Its own port, armed; the children's records are given by hand."""

    def __init__(self, folder: Path) -> None:
        self.now_s = 100.0
        self.settings: dict[str, int] | None = SETTINGS
        self.ended: list[tuple[str, int]] = []
        """Presses that were ended before their goal."""
        self.outputs: list[ModeOutput] = []
        self.cap_permille = 1000
        self._mode, self._press = "", 0
        self._services = {kind: self._service(kind, folder) for kind in KINDS}
        self._producers = Producers(tuple(self._services.values()))

    def _service(self, kind: str, folder: Path) -> ProducerService:
        made = ProducerService(
            kind,
            (LidarConfig(kind="s2", port="/nowhere"),),
            child_setup(FootprintConfig(), folder, folder),
            Health(f"mode {kind}"),
            lambda: {f"to-{kind}": Target(kind, "star", {})},
            lambda: self.now_s,
        )
        made.connect(self, lambda: self.settings, lambda: "")  # type: ignore[arg-type]
        made.look()
        made._on_data(exchange.pack(self.now_s, 0, Output(None)))
        return made

    def offer_mode(self, mode: str, tile: dict[str, Any] | None) -> None: ...

    def mode_output(
        self, mode: str, number: int, output: ModeOutput, _till_s: float, reached: bool = True
    ) -> None:
        self.outputs.append(output)
        if output is None and not reached:
            self.ended.append((mode, number))

    def mode_context(self) -> ModeContext:
        nothing = dict.fromkeys(SEES)
        known = (True, 0.0, 0.0, nothing, SEES)
        return ModeContext(self._mode, self._press, self.now_s, *known, self.cap_permille)

    def _tick(self) -> None:
        for service in self._services.values():
            service.tick()
        self.now_s += 0.02

    def goes(self, kind: str, stick: tuple[int, int] = (200, 0)) -> None:
        """Press a tile of that kind."""
        self._mode, self._press = f"to-{kind}", self._press + 1
        self._tick()
        record = exchange.pack(self.now_s, self._press, Output(stick, "drives"))
        self._services[kind]._on_data(record)
        self._tick()

    def gives(self, kind: str, late_s: float) -> None:
        """A value that is so old when it arrives."""
        born_s = self.now_s - late_s
        record = exchange.pack(born_s, self._press, Output((200, 0), "drives"))
        self._services[kind]._on_data(record)
        self._tick()

    def lets_go(self) -> None:
        """The press is over."""
        self._mode = ""
        self._tick()

    def ends(self, kind: str, state: str, reason: str = "") -> None:
        """Its producer ends the motion."""
        record = exchange.pack(self.now_s, self._press, Output(None, state, reason))
        self._services[kind]._on_data(record)
        self.lets_go()

    @property
    def news(self) -> tuple[str, ...] | None:
        """Kind, state and reason."""
        reported = self._producers.news()
        return (
            None if reported is None else (reported["kind"], reported["state"], reported["reason"])
        )


@pytest.fixture
def chair(tmp_path: Path) -> Chair:
    return Chair(tmp_path)


def test_an_older_arrival_is_not_told_again_when_another_motion_ends(chair: Chair) -> None:
    assert chair.news is None
    chair.goes("place")
    chair.ends("place", "arrived")
    assert chair.news == ("place", "arrived", "")
    chair.now_s += 20.0
    chair.goes("person")
    assert chair.news == ("person", "drives", "")
    chair.ends("person", "ended", "person_lost")
    assert chair.news == ("person", "ended", "person_lost")
    chair.now_s += 50.0  # the older one is shown no more
    assert chair.news == ("person", "ended", "person_lost")
    chair.now_s += 11.0
    assert chair.news is None


def test_an_arrival_is_told_after_an_older_end_and_another_motion_at_once(chair: Chair) -> None:
    chair.goes("place")
    chair.ends("place", "ended", "going_lost")
    chair.goes("line")
    chair.ends("line", "arrived")
    assert chair.news == ("line", "arrived", "")
    chair.goes("place")
    chair.goes("person")  # without letting go
    assert chair.news == ("person", "drives", "")
    chair.ends("person", "arrived")
    assert chair.news == ("person", "arrived", "")


@pytest.mark.parametrize("kind", KINDS)
def test_a_press_while_the_boards_settings_are_unknown_ends_with_a_reason(
    chair: Chair, kind: str
) -> None:
    chair.settings = None  # since the last look: its tile is still there
    chair.goes(kind)
    assert chair.news == (kind, "ended", "going_failed")
    assert chair.ended == [(f"to-{kind}", 1)]
    chair.settings = SETTINGS
    chair.goes(kind)
    assert chair.news == (kind, "drives", "")
    assert len(chair.ended) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_under_the_caretakers_cap_the_curve_stays_the_same(chair: Chair, kind: str) -> None:
    """The board cuts each axis by itself: of this curve only the speed, so it turned tighter."""
    chair.goes(kind, (576, 130))
    chair.cap_permille = 300
    chair.goes(kind, (576, 130))
    chair.goes(kind, (0, 679))
    # Profile 3.1 has a deadband of 56: both move it at 47 % of what was asked.
    assert chair.outputs == [(576, 130), (300, 91), (0, 300)]


@pytest.mark.parametrize(("late_s", "reason"), [(0.1, "going_stopped"), (0.2, "going_failed")])
def test_a_producer_whose_values_come_too_late_has_failed_and_nobody_has_stopped(
    chair: Chair, late_s: float, reason: str
) -> None:
    """A value lives 150 ms (P17): later ones move nothing, so the press ends by itself."""
    chair.goes("place")
    for _ in range(15):
        chair.gives("place", late_s)
    chair.lets_go()
    assert chair.news == ("place", "ended", reason)
