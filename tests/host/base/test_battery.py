"""The computer's battery: found among other devices that report a charge."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazechair.base.battery import charge_percent


def supply(folder: Path, name: str, **files: str) -> None:
    (folder / name).mkdir()
    for file, text in files.items():
        (folder / name / file).write_text(text + "\n")


def test_the_emptiest_battery_counts_and_mains_or_a_mouse_do_not(tmp_path: Path) -> None:
    supply(tmp_path, "AC", type="Mains", online="1")
    supply(tmp_path, "mouse", type="Battery", scope="Device", capacity="3")
    assert charge_percent(tmp_path) is None
    supply(tmp_path, "BAT0", type="Battery", capacity="84")
    supply(tmp_path, "BAT1", type="Battery", scope="System", capacity="61")
    assert charge_percent(tmp_path) == 61


@pytest.mark.parametrize("capacity", ["", "101", "-3", "full", "\u00b2"])
def test_nonsense_is_no_charge(tmp_path: Path, capacity: str) -> None:
    supply(tmp_path, "BAT0", type="Battery", capacity=capacity)
    assert charge_percent(tmp_path) is None


def test_a_computer_without_any_of_it_has_none(tmp_path: Path) -> None:
    assert charge_percent(tmp_path / "nothing") is None
    supply(tmp_path, "BAT0", type="Battery")
    assert charge_percent(tmp_path) is None
