"""Turns on the spot, with chairs whose physics differ from the model's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.pace import PERIOD_S
from gazechair.going.spot_turn import SpotTurn
from gazelink.settings_table import PROFILES, TABLE
from gazemeasure.obstacles.attack import KINDS, AttackedChair
from gazemeasure.turn.board import settings_with
from gazesim.chair import Chair

CAP = 469  # of an auto motion, until the board trusts the profile
WITHIN_DEG = 1.2
LATE = 2  # periods, of what is measured
ANGLES_DEG = (90.0, -25.0, 7.0, 150.0, -90.0, 12.0)


class Turning:
    """A chair, its model, and turns; the heading is 0.1 s late, with errors."""

    def __init__(self, kind: str, seed: int) -> None:
        settings = settings_with(
            {"profile": PROFILES.index("3.1"), "linear_permille": 1000, "turn_permille": 1000}
        )
        numbers = ChairNumbers.of({row[0]: getattr(settings, row[0]) for row in TABLE})
        self.chair: Chair | AttackedChair = (
            Chair("3.1", seed)
            if kind == "twin"
            else AttackedChair("3.1", kind, settings, bool(seed % 2))
        )
        self.chair.step(0.01, (0.0, 0.0))
        self.model = numbers.turn_axis()
        self.spot = SpotTurn(self.model, numbers.spot_permille, PERIOD_S)
        self.random = np.random.default_rng(seed)
        self.seen = [(0.0, 0.0)] * (1 + LATE)

    def turn(self, angle_deg: float, most_s: float) -> tuple[float, float]:
        """Seconds, and the final error in degrees."""
        target, put_out, at_s = self.chair.heading_deg + angle_deg, 0, 0.0
        self.spot.start()
        while at_s < most_s:
            noise = self.random.normal(0.0, (0.15, 0.3))
            now = (self.chair.heading_deg + noise[0], self.chair.yaw_rate_deg_s + noise[1])
            self.seen = [*self.seen[1:], now]
            heading_deg, rate = self.seen[0]
            self.model.put_out(put_out, PERIOD_S, rate, LATE * PERIOD_S)
            self.spot.let_out(put_out)
            heading = math.radians(heading_deg + LATE * PERIOD_S * rate)
            asked = self.spot.step(heading, math.radians(target), math.radians(WITHIN_DEG))
            if asked is None:
                break
            put_out = max(-CAP, min(CAP, asked))
            self._run(put_out, PERIOD_S)
            at_s += PERIOD_S
        self._run(0, 1.0)
        self.model.put_out(0, 1.0, 0.0)
        return at_s, abs(target - self.chair.heading_deg)

    def _run(self, put_out: int, seconds: float) -> None:
        for _ in range(round(seconds / 0.01)):
            self.chair.step(0.01, (0.0, put_out / 1000.0))


@pytest.mark.parametrize("kind", ["twin", *KINDS])
@pytest.mark.parametrize("seed", range(1, 9))
def test_a_turn_ends_at_its_target_in_time(kind: str, seed: int) -> None:
    turning = Turning(kind, seed)
    done = [turning.turn(angle, 20.0) for angle in ANGLES_DEG]
    assert max(off for _, off in done) < 3.0
    # At 20 degrees/s, with some seconds for ramps and corrections.
    slack_s = [at_s - abs(angle) / 20.0 for (at_s, _), angle in zip(done, ANGLES_DEG, strict=True)]
    assert sum(slack_s) / len(slack_s) < 4.0
    assert max(slack_s) < 10.0


def test_what_the_board_held_back_teaches_nothing() -> None:
    turning = Turning("exact", 1)
    for angle in ANGLES_DEG:
        turning.turn(angle, 20.0)
    shift = turning.spot._shift
    turning.spot.start()
    for _ in range(100):  # requested, without output
        turning.model.put_out(0, PERIOD_S, 0.0)
        turning.spot.let_out(0)
        heading = math.radians(turning.chair.heading_deg)
        turning.spot.step(heading, heading + math.radians(5.0), math.radians(WITHIN_DEG))
    assert turning.spot._shift == shift


def test_where_no_pulse_turns_the_chair_the_stick_is_held_until_the_board_lets_more_out() -> None:
    settings = settings_with({"profile": PROFILES.index("1.2"), "turn_permille": 1000})
    numbers = ChairNumbers.of({row[0]: getattr(settings, row[0]) for row in TABLE})
    spot = SpotTurn(numbers.turn_axis(), numbers.spot_permille, PERIOD_S)
    longest = held = put_out = 0
    for _ in range(round(10.0 / PERIOD_S)):
        spot.let_out(put_out)
        asked = spot.step(0.0, math.radians(-7.0), math.radians(WITHIN_DEG))
        assert asked is not None
        held = held + 1 if asked else 0
        longest = max(longest, held)
        put_out = max(-CAP, asked)
    assert longest * PERIOD_S > 2.0  # limits.TRYING_MS, and what the chair needs then
