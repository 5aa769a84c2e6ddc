"""The tick's budget, counted in instructions on the emulated board: the same on every machine."""

from __future__ import annotations

import pytest

from gazemeasure import emulation, tick

pytestmark = [pytest.mark.m7, pytest.mark.recorded, pytest.mark.xdist_group("board")]


@pytest.mark.usefixtures("m7")
def test_no_tick_of_ten_seconds_at_the_worst_load_takes_longer_than_its_budget() -> None:
    found, _ = tick._load(tick._RUN_MS_QUICK, state_period_ms=1)
    worst = (found["worst_us"] - tick._WIRE_US) * emulation.INSTRUCTIONS_PER_US
    assert 10_000 < worst <= tick._INSTRUCTIONS
    assert found["missed"] == 0
    assert found["ticks"] >= tick._RUN_MS_QUICK
