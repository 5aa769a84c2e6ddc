"""Maps over HTTP: caretakers change them, every page sees where the chair is, nobody else edits."""

from __future__ import annotations

import json
from typing import Any

import pytest


def test_a_caretaker_draws_and_everybody_sees(visitor: Any, maps: Any) -> None:
    caretaker, driver = visitor("caretaker"), visitor("driver")
    place = {"name": "Bed", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0}
    status, _, answer = caretaker.post("/maps", {"map": "a", "place": place})
    assert (status, [row["name"] for row in answer["maps"]]) == (200, ["home"])
    status, _, raw = driver.get("/maps/a")
    details = json.loads(raw)
    assert (status, details["places"][0]["name"]) == (200, "Bed")
    assert details["picture"]["width"] == 40
    status, headers, png = driver.get("/maps/a.png")
    assert (status, headers["Content-Type"], png[:4]) == (200, "image/png", b"\x89PNG")
    assert driver.get("/maps/a.png", **{"If-None-Match": headers["ETag"]})[0] == 304
    assert json.loads(driver.get("/maps/where")[2]) == {"where": None}
    assert caretaker.get("/maps/growing.png")[0] == 404
    assert json.loads(caretaker.get("/maps/growing")[2]) == {"picture": None}


@pytest.mark.parametrize(
    ("wish", "status", "reason"),
    [
        ({"map": "a", "rename": "\U0001f3e0" * 60}, 400, "map_name"),
        ({"map": "../../a", "rename": "x"}, 404, "map_gone"),
        ({"map": "a", "place": 1}, 400, "map_wish"),
        ({"make": True}, 409, "map_no_lidar"),
        ({"map": "zz", "delete": True}, 404, "map_gone"),
    ],
)
def test_a_refusal_has_its_reason(
    visitor: Any, maps: Any, wish: dict[str, Any], status: int, reason: str
) -> None:
    answered, _, answer = visitor("caretaker").post("/maps", wish)
    assert (answered, answer["reason"]) == (status, reason)


def test_a_name_of_10000_signs_is_not_even_read(visitor: Any) -> None:
    wish = {"map": "a", "rename": "\U0001f3e0" * 10_000}
    assert visitor("caretaker").post("/maps", wish)[0] == 413


@pytest.mark.parametrize("path", ["/maps/..%2fa", "/maps/%2e%2e", "/maps/b", "/maps/b.png"])
def test_a_map_that_is_not_there(visitor: Any, path: str) -> None:
    assert visitor("driver").get(path)[0] == 404


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_nobody_else_may_change_them(visitor: Any, maps: Any, role: str) -> None:
    other = visitor(role)
    assert other.get("/maps")[0] == 403
    assert other.get("/maps/growing")[0] == 403
    for wish in ({"map": "a", "rename": "x"}, {"make": True}, {"map": "a", "delete": True}):
        assert other.post("/maps", wish)[0] == 403
    assert maps.as_json()["maps"][0]["name"] == "home"


def test_who_is_not_paired_sees_nothing(visitor: Any) -> None:
    stranger = visitor(None)
    for path in ("/maps", "/maps/where", "/maps/a", "/maps/a.png"):
        assert stranger.get(path)[0] == 401
