"""The board's settings for driving straight, from what was measured, and text about them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from gazechair.commissioning.tune.forward import STEP_M, ForwardNumbers
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row

_FASTER = 1.05  # safety factor on the measured speed


def straight_rows(
    numbers: ForwardNumbers, profile: str, before: Sequence[int], turns: TurnNumbers
) -> dict[str, int]:
    """{setting: value} to store for `profile`; `before`: the values in force, except `turns`. A
    faster speed or weaker braking in force stays. Raises TuneError if it brakes too weakly."""
    usual = TurnNumbers.default(profile)
    # As on the board: the worse of the setting and the measured value.
    acts_s = max(turns.dead_time_s, usual.dead_time_s) + max(turns.lag_s, usual.lag_s)
    acts_s = max(acts_s, before[index_of("reaction_ms")] / 1000.0)
    row = PROFILES.index(profile)
    speed, brake = profile_row(row, "forward_mm_s"), profile_row(row, "brake_mm_s2")
    _, usual_mm_s, low, high = TABLE[index_of(speed)]
    _, usual_mm_s2, _, _ = TABLE[index_of(brake)]
    was_mm_s, was_mm_s2 = before[index_of(speed)], before[index_of(brake)]
    found_mm_s = math.ceil(1000.0 * numbers.full_m_s * _FASTER)
    found_mm_s2 = numbers.brake_row_mm_s2(acts_s)
    permille, ramp_ms = (before[index_of(name)] for name in ("linear_permille", "step_ramp_ms"))
    most_ms = TABLE[index_of("step_forward_ms")][3]
    return {
        speed: max(low, min(high, found_mm_s), was_mm_s if was_mm_s > usual_mm_s else 0),
        brake: min(found_mm_s2, was_mm_s2) if was_mm_s2 < usual_mm_s2 else found_mm_s2,
        "step_forward_ms": numbers.step_ms(permille, ramp_ms, most_ms),
    }


def straight_lines(
    numbers: ForwardNumbers, rows: Mapping[str, int], before: Sequence[int], profile: str
) -> Iterator[str]:
    """The result as lines for a person."""
    row = PROFILES.index(profile)
    for name, words, unit in (
        (profile_row(row, "forward_mm_s"), "forward, at most", "mm/s"),
        (profile_row(row, "brake_mm_s2"), "brakes, at least", "mm/s2"),
        ("step_forward_ms", "a step forward", "ms"),
    ):
        yield f"{words:<24}{before[index_of(name)]:>10}{rows[name]:>10} {unit}"
    permille, ramp_ms = (before[index_of(name)] for name in ("linear_permille", "step_ramp_ms"))
    way_m = numbers.step_m(permille, ramp_ms, rows["step_forward_ms"])
    less = "" if way_m > 0.95 * STEP_M else ": it may not last longer"
    yield f"a step forward goes {way_m:.2f} m in profile {profile}{less}"
