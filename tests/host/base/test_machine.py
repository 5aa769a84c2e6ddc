"""A computer that is too slow or too hot is reported, and so is its recovery."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazechair.base.health import Health
from gazechair.base.machine import MANY, WINDOW, Machine


class Computer:
    def __init__(self, folder: Path) -> None:
        self.late_s = 0.0
        self.zone = folder / "thermal_zone3"
        self.zone.mkdir()
        self.is_c(45)
        self.health = Health("host")
        self.machine = Machine(self.health, lambda: self.late_s, folder)

    def is_c(self, degrees: float) -> None:
        (self.zone / "temp").write_text(f"{degrees * 1000:.0f}\n")

    def reason_after(self, seconds: int) -> str:
        for _ in range(seconds):
            self.machine.look()
        return self.health.reason


@pytest.fixture
def computer(tmp_path: Path) -> Computer:
    return Computer(tmp_path)


def test_a_computer_that_keeps_up_is_well_from_the_start(computer: Computer) -> None:
    assert computer.health.reason == "ok"
    assert computer.reason_after(60) == "ok"


def test_a_moment_of_lateness_is_nothing_and_half_of_the_time_is_told(computer: Computer) -> None:
    computer.late_s = 0.3
    assert computer.reason_after(MANY - 1) == "ok"
    assert computer.reason_after(1) == "host_slow"
    computer.late_s = 0.01
    assert computer.reason_after(WINDOW - 1) == "host_slow"
    assert computer.reason_after(1) == "ok"


def test_heat_is_told_until_it_is_well_below(computer: Computer) -> None:
    computer.is_c(91)
    assert computer.reason_after(1) == "host_hot"
    assert "91 degrees" in computer.health.detail
    computer.is_c(87)
    assert computer.reason_after(5) == "host_hot"
    computer.is_c(84)
    assert computer.reason_after(1) == "ok"


@pytest.mark.parametrize("text", ["", "-273000\n", "999999000\n", "hot"])
def test_a_sensor_that_says_nonsense_does_not_count(computer: Computer, text: str) -> None:
    (computer.zone / "temp").write_text(text)
    assert computer.reason_after(3) == "ok"


def test_no_sensor_and_one_that_cannot_be_read_are_nothing(tmp_path: Path) -> None:
    (tmp_path / "thermal_zone0" / "temp").mkdir(parents=True)
    health = Health("host")
    Machine(health, lambda: 0.0, tmp_path).look()
    Machine(health, lambda: 0.0, tmp_path / "none").look()
    assert health.reason == "ok"
