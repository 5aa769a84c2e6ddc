"""What stopping takes, by the settings' default numbers; the stop zone of the fastest profile."""

from __future__ import annotations

from gazelink import codes
from gazelink.settings_table import NAMES, PROFILES, TABLE, profile_row

_ROWS = {name: TABLE[NAMES.index(name)] for name in NAMES}


def _default(name: str) -> int:
    return int(_ROWS[name][1])


REACTION_S = _default("reaction_ms") / 1000.0
"""From an obstacle's echo to the first braking."""
CREEP_M_S = _default("creep_mm_s") / 1000.0
"""The board's slowest speed."""
STOP_MARGIN_M = _default("stop_margin_mm") / 1000.0


def _stop(speeds: list[int], brakes: list[int], margin: float) -> float:
    # d = v t + v^2 / 2a + margin, the largest of all profiles.
    ways = [v * REACTION_S + v * v / (2.0 * a) for v, a in zip(speeds, brakes, strict=True)]
    return max(ways) + margin


def _of_profiles(name: str) -> list[int]:
    return [_default(profile_row(at, name)) for at in range(len(PROFILES))]


BRAKE_M_S2 = min(_of_profiles("brake_mm_s2")) / 1000.0


def _zones() -> dict[int, float]:
    brakes = _of_profiles("brake_mm_s2")
    turning = [16 * rate for rate in _of_profiles("brake_dps2")]
    margin_mm, margin_q4 = _default("stop_margin_mm"), _default("stop_margin_q4_deg")
    return {
        codes.DIR_FORWARD: _stop(_of_profiles("forward_mm_s"), brakes, margin_mm) / 1000.0,
        codes.DIR_BACKWARD: _stop(_of_profiles("backward_mm_s"), brakes, margin_mm) / 1000.0,
        codes.DIR_LEFT: _stop(_of_profiles("left_q4_dps"), turning, margin_q4) / 16.0,
        codes.DIR_RIGHT: _stop(_of_profiles("right_q4_dps"), turning, margin_q4) / 16.0,
    }


STOP_ZONE = _zones()
"""Per direction: metres or degrees in which the fastest profile stops. It could not wait for a
second look there."""
