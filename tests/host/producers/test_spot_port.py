"""Spots of the picture: from the page that drives alone, whole and fresh; they move nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from gazechair.producers.spot_port import SpotPort
from gazesim.lockstep_chair import Lockstep
from gazesim.lockstep_page import Page


class Chair(Lockstep):
    """Armed; `chosen`: every spot that got through."""

    def __init__(self) -> None:
        super().__init__()
        self.chosen: list[tuple[Any, ...]] = []
        assert self.host is not None

        def choose(*what: Any) -> bool:
            self.chosen.append(what)
            return what[0] == "follow-line"

        self.host.port = SpotPort(self.host.control, self.host.control, choose)
        self.arm()

    def refused(self) -> str:
        self.run(30)
        assert self.host is not None
        return self.host.refusals[-1] if self.host.refusals else ""


@pytest.fixture(scope="module")
def chair() -> Chair:
    return Chair()


def test_a_spot_gets_through_with_the_moment_of_the_look(chair: Chair) -> None:
    now_s = chair.now_s()
    chair.page.spot("follow-line", (0.25, 1))
    assert chair.refused() == ""
    tile, at, at_s = chair.chosen[-1]
    assert (tile, at) == ("follow-line", (0.25, 1.0))
    assert at_s <= now_s + 0.01
    assert at_s > now_s - 0.2
    chair.page.spot("follow-line", None)
    chair.run(30)
    assert chair.chosen[-1][1] is None
    chair.page.spot("another", (0.5, 0.5))
    assert chair.refused() == "no_answer"
    assert chair.harmless()


FOREIGN = [
    *([1.1, 0.5], [-0.1, 0.5], [0.5], [0.5, 0.5, 0.5], [True, 0.5], ["0.5", 0.5]),
    *([math.nan, 0.5], [math.inf, 0.5], {"0": 0.5}, "at", 0.5, [[0.5], 0.5], [10**400, 0.5]),
]


@pytest.mark.parametrize("at", FOREIGN, ids=range(len(FOREIGN)))
def test_what_is_no_spot_is_refused(chair: Chair, at: Any) -> None:
    count = len(chair.chosen)
    assert chair.host is not None
    token = chair.host.control.token()
    for more in ({"tile": "follow-line", "at": at}, {"tile": 7, "at": None}, {}):
        if not more:
            token = -1
        sent = chair.host.port.receive(chair.page.client, {"k": "spot", "token": token, **more})
        assert sent[0]["reason"] == "bad_message"
    assert len(chair.chosen) == count


def test_another_page_a_caretaker_a_viewer_and_a_late_one_choose_nothing(chair: Chair) -> None:
    count = len(chair.chosen)
    assert chair.host is not None
    spot = {"k": "spot", "tile": "follow-line", "at": [0.5, 0.5]}
    for role in ("driver", "caretaker", "viewer"):
        page = Page(chair.host, role)
        sent = chair.host.port.receive(page.client, {**spot, "token": chair.host.control.token()})
        assert sent[0]["reason"] == "not_owner"
        page.close()
    old = chair.host.control.token()
    chair.run(1500)
    sent = chair.host.port.receive(chair.page.client, {**spot, "token": old})
    assert sent[0]["reason"] == "stale_token"
    assert len(chair.chosen) == count
    assert chair.harmless()
