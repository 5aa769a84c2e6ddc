"""Behaviour of a chair that tuning must not accept: each is refused, with its reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gazeboard.io.joystick import permille as reported
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.identify import Fit, identify
from gazechair.commissioning.tune.judge import fits_profile, judge
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.procedure import Procedure
from gazechair.commissioning.tune.recording import Pulse, Recording, Sample
from gazelink import codes
from gazesim.board_limits import LIMITS

NEUTRAL = 170
BELIEVED = TurnNumbers.default("3.1")
SURE = TurnNumbers(*[0.01] * 8)


class Script:
    """A chair that turns at `rate_dps` per full deflection at once, with one fault."""

    def __init__(self, rate_dps: float = 40.0) -> None:
        self.rate_dps = rate_dps
        self.neutral = NEUTRAL
        self.noise_deg = 0.0
        self.drift_dps = 0.0
        self.override_after_ms = 1 << 30
        self.moves_wiper = True
        self.share = 1.0
        self.period_ms = 10
        self.ms = 0
        self.heading_deg = 0.0
        self._random = np.random.default_rng(1)
        self._held: Pulse | None = None
        self._left_ms = 0

    def run(self, procedure: Procedure, limit_ms: int = 200_000) -> None:
        """Samples until it is done."""
        while not procedure.done and self.ms < limit_ms:
            if procedure.wanted is not self._held:
                self._held = procedure.wanted
                self._left_ms = self._held.pulse_ms if self._held else 0
            permille = self._held.turn_permille if self._held and self._left_ms > 0 else 0
            self._left_ms -= self.period_ms
            self.ms += self.period_ms
            deflection = permille / 1000 * self.share
            rate = self.rate_dps * deflection + self.drift_dps
            self.heading_deg += rate * self.period_ms / 1000
            count = max(85, min(254, self.neutral + round(84 * deflection)))
            if not self.moves_wiper:
                count = self.neutral
            reason = codes.OBSTACLE_LEFT if self.ms > self.override_after_ms and permille else 0
            seen = self.heading_deg + self._random.normal(0.0, self.noise_deg)
            procedure.sample(Sample(self.ms, seen, reported(count, self.neutral), reason))


def refused(script: Script) -> str:
    with pytest.raises(TuneError) as caught:
        script.run(Procedure(BELIEVED, NEUTRAL, LIMITS))
    return str(caught.value)


def test_a_good_chair_is_recorded_whole() -> None:
    procedure = Procedure(BELIEVED, NEUTRAL, LIMITS)
    Script().run(procedure)
    assert procedure.done
    assert procedure.wanted is None
    assert len(procedure.recordings) == 10


@pytest.mark.parametrize("neutral", [150, 160, 180, 190])
def test_a_joystick_whose_neutral_is_another_count_is_no_slower_board(neutral: int) -> None:
    """To one side the wiper comes to the end of its window before 84 counts."""
    script, procedure = Script(), Procedure(BELIEVED, neutral, LIMITS)
    script.neutral = neutral
    script.run(procedure)
    assert procedure.done
    most = {r.deflection > 0: r.full_deflection for r in procedure.recordings}
    assert most[True] == pytest.approx(min(84, 254 - neutral) / 84.5)
    assert most[False] == pytest.approx(min(84, neutral - 85) / 84.5)
    assert max(r.deflection for r in procedure.recordings) == most[True]
    assert min(r.deflection for r in procedure.recordings) == -most[False]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"rate_dps": 0.0}, "did not turn"),
        ({"rate_dps": -40.0}, "the other way"),
        ({"noise_deg": 3.0}, "does not come to rest"),
        ({"drift_dps": 2.0}, "does not come to rest"),
        ({"moves_wiper": False}, "does not move the wiper"),
        ({"override_after_ms": 3000}, "stopped the pulse: obstacle_left"),
        ({"share": 0.5}, "slower than asked for"),
        ({"period_ms": 60}, "this computer stalls"),
        ({"rate_dps": 6000.0}, "far more than asked for"),
    ],
)
def test_a_chair_that_does_not_answer_as_it_should(change: dict[str, float], reason: str) -> None:
    script = Script()
    for name, value in change.items():
        setattr(script, name, value)
    assert reason in refused(script)


def test_a_reversed_chair_is_found_out_before_it_has_turned_far() -> None:
    script = Script(-40.0)
    refused(script)
    assert abs(script.heading_deg) < 45.0


def recordings(turned_deg: float) -> list[Recording]:
    time_s = np.array([0.0, 1.0])
    return [Recording(1.0, 0.5, time_s, np.array([0.0, turned_deg]), 0.0)] * 4


GOOD = TurnNumbers(45.0, 44.0, 0.1, 0.15, 0.25, 120.0, 180.0, 5.0)


@pytest.mark.parametrize(
    ("turned_deg", "fit", "reason"),
    [
        (1.0, Fit(GOOD, 0.1, 0.02, SURE), "turned only 1.0 degrees a pulse"),
        (12.0, Fit(GOOD, 2.0, 0.02, SURE), "do not repeat"),
        (12.0, Fit(GOOD, 0.1, 0.12, SURE), "do not repeat .they differ by 12 %"),
        (12.0, Fit(GOOD, 0.1, 0.02, replace(SURE, left_dps=0.5)), "do not show how fast"),
        (12.0, Fit(replace(GOOD, right_dps=12.0), 0.1, 0.02, SURE), "a brake dragging"),
        (12.0, Fit(replace(GOOD, dead_time_s=0.45), 0.1, 0.02, SURE), "dead_time_ms would be 450"),
        (12.0, Fit(replace(GOOD, lag_s=0.01), 0.1, 0.02, SURE), "lag_ms would be 10"),
    ],
)
def test_poor_data_and_odd_chairs_are_refused(turned_deg: float, fit: Fit, reason: str) -> None:
    with pytest.raises(TuneError, match=reason):
        judge(recordings(turned_deg), fit)


def test_good_data_pass() -> None:
    judge(recordings(12.0), Fit(GOOD, 0.1, 0.02, SURE))


@pytest.mark.parametrize("factor", [0.7, 1.0, 1.3])
def test_load_and_floor_do_not_make_another_profile(factor: float) -> None:
    for profile in ("1.2", "2.1", "3.1", "4.1", "5.1"):
        believed = TurnNumbers.default(profile)
        fits_profile(
            replace(
                believed,
                left_dps=believed.left_dps * factor,
                right_dps=believed.right_dps * factor,
            ),
            profile,
        )


@pytest.mark.parametrize(("named", "selected"), [("1.2", "4.1"), ("4.1", "1.2"), ("2.1", "1.2")])
def test_another_profile_than_named_is_refused_with_the_one_that_fits(
    named: str, selected: str
) -> None:
    with pytest.raises(TuneError, match=f"not as profile {named} does, rather as {selected}"):
        fits_profile(TurnNumbers.default(selected), named)


@pytest.mark.parametrize(
    "factors",
    [
        (1, 1, 0.4, 1.6, 0.5, 2, 1.7, 0.3, 1.5, 0.4),
        (1, 0.8, 1.2, 0.8, 0.75, 1.2, 1.25, 0.8, 1.2, 0.75),
    ],
)
def test_turns_that_no_two_pulses_agree_on_are_refused(factors: tuple[float, ...]) -> None:
    procedure = Procedure(BELIEVED, NEUTRAL, LIMITS)
    Script().run(procedure)
    torn = [
        replace(r, heading_deg=r.heading_deg * factor)
        for r, factor in zip(procedure.recordings, factors, strict=True)
    ]
    with pytest.raises(TuneError, match="do not repeat"):
        judge(torn, identify(torn, BELIEVED))
