"""Which page closes for a new one: no device locks out others, and the driving page stays."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.web.role_limits import ConnectedPage, Full, makes_way

MOST = 4


def one(device: str, received_s: float = 0.0, drives: bool = False) -> ConnectedPage[str]:
    return ConnectedPage(f"{device} {received_s}", device, received_s, drives)


def test_a_free_seat_is_taken() -> None:
    assert makes_way([], MOST, "a") is None
    assert makes_way([one("a"), one("b")], MOST, "c") is None


def test_four_tabs_of_one_device_leave_a_seat_for_another() -> None:
    tabs = [one("a", k) for k in range(MOST - 1)]
    assert makes_way(tabs, MOST, "a") == "a 0"  # its own most silent one
    assert makes_way(tabs, MOST, "b") is None


def test_who_has_many_makes_way_for_who_has_none() -> None:
    connected = [one("a", 2.0), one("a", 1.0), one("a", 3.0), one("b", 0.0)]
    assert makes_way(connected, MOST, "c") == "a 1.0"


def test_the_page_that_drives_is_not_moved_by_another_device() -> None:
    connected = [one("a", 0.0, drives=True), one("a", 1.0), one("b"), one("c")]
    assert makes_way(connected, MOST, "d") == "a 1.0"
    assert makes_way(connected, MOST, "b") == "b 0.0"  # its own


def test_a_seat_each_is_full() -> None:
    with pytest.raises(Full):
        makes_way([one(device) for device in "abcd"], MOST, "e")


@given(st.lists(st.tuples(st.sampled_from("abc"), st.booleans()), max_size=60))
def test_with_fewer_devices_than_seats_everybody_gets_in(visits: list[tuple[str, bool]]) -> None:
    connected: list[ConnectedPage[str]] = []
    for now, (device, drives) in enumerate(visits):
        goes = makes_way(connected, MOST, device)  # raises Full: no device is ever locked out
        driving = [s for s in connected if s.drives]
        left = [s for s in connected if s.page != goes]
        assert all(s in left or s.device_id == device for s in driving)
        drives = drives and not any(s.drives for s in left)
        connected = [*left, one(device, float(now), drives)]
        assert len(connected) <= MOST
