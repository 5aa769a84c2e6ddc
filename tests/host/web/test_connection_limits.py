"""Which connection closes when too many are new. Virtual time."""

from __future__ import annotations

import pytest

from gazechair.web.connection_limits import (
    LONGEST_NEW_S,
    MOST_NEW,
    MOST_NEW_OF_ADDRESS,
    OpenConnections,
)


class Line:
    """A connection that records being cut."""

    def __init__(self) -> None:
        self.cut = False

    def shutdown(self, _: int) -> None:
        self.cut = True


class House:
    def __init__(self) -> None:
        self.now_s = 100.0
        self.connections = OpenConnections(lambda: self.now_s)

    def come(self, address: str = "192.0.2.1") -> Line:
        self.now_s += 0.001
        line = Line()
        self.connections.admit(line, address)
        return line


@pytest.fixture
def house() -> House:
    return House()


def test_of_one_address_the_longest_new_goes(house: House) -> None:
    lines = [house.come() for _ in range(MOST_NEW_OF_ADDRESS + 2)]
    assert [line.cut for line in lines] == [True, True] + [False] * MOST_NEW_OF_ADDRESS
    assert not house.come("192.0.2.2").cut


def test_of_many_addresses_the_longest_new_goes(house: House) -> None:
    lines = [house.come(f"192.0.2.{k}") for k in range(MOST_NEW + 1)]
    assert [line.cut for line in lines] == [True] + [False] * MOST_NEW
    assert house.connections.new == MOST_NEW


def test_who_has_settled_stays_however_many_come(house: House) -> None:
    driver = house.come()
    house.connections.settle(driver, "control 3fa2b1")
    for k in range(2000):
        house.come(f"198.51.{k >> 8}.{k & 255}")
    for _ in range(100):
        house.come()
    house.now_s += 1000
    house.connections.cut_overdue()
    assert not driver.cut
    assert house.connections.new == 0


def test_new_for_too_long_goes(house: House) -> None:
    slow = house.come()
    house.now_s += LONGEST_NEW_S - 1
    quick = house.come()
    house.connections.cut_overdue()
    assert not slow.cut
    house.now_s += 1.1
    house.connections.cut_overdue()
    assert (slow.cut, quick.cut) == (True, False)


def test_who_left_takes_no_place(house: House) -> None:
    for _ in range(500):
        line = house.come()
        house.connections.leave(line)
        assert not line.cut
    assert house.connections.new == 0


def test_a_devices_sockets_are_found(house: House) -> None:
    lines = [house.come() for _ in range(3)]
    for line, what in zip(lines, ("picture aa", "picture bb", "control aa"), strict=True):
        house.connections.settle(line, what)
    house.connections.settle(Line(), "picture aa")  # gone already
    house.connections.cut_settled("picture aa")
    assert [line.cut for line in lines] == [True, False, False]
