"""Finds a chair's numbers from recorded pulses: the model's least disagreement with all of them.

A descent (descent.py) from several starts: a coarse search, then a fine one from the best three.
The priors from comparable chairs (beliefs.py) count as much as a few samples: they decide only
what the pulses leave open. Errors of one pulse's samples are correlated, as they share the
floor; so every pulse has its own fraction by which it turned further.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.commissioning.tune import beliefs, model
from gazechair.commissioning.tune.descent import Valley, descend
from gazechair.commissioning.tune.model import Pulses
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording

# (error of a sample, degrees; steps): for every start, and for the best three
_COARSE = (1.0, 10)
_SHARP = (0.3, 40)
_BEST = 3
_STUCK_DPS = 0.5  # tolerance of a ramp around the speed at which the chair breaks loose
# The casters' position at the start, and the degrees by which they turn the chair.
_STARTS = ((0.0, 0.0), (0.0, 8.0), (0.0, -8.0), (1.0, 8.0), (1.0, -8.0), (0.5, 8.0), (0.5, -8.0))
_BRISK = (4.8, 1.0)  # a chair that starts at once: its ramp, log degrees/s2, and its stiction
_EVERY = 2  # samples: neighbours add little information
_NUDGE = 1e-4


@dataclass(frozen=True)
class Fit:
    """The result, and its quality."""

    numbers: TurnNumbers
    residual_deg: float
    """Root mean square of what the model leaves unexplained."""
    uneven: float
    """Root mean square of the shares by which single pulses turned further than the others."""
    spread: TurnNumbers
    """Standard error of each number, as a share of it (of the deadband and dead time: as is)."""


def identify(recordings: Sequence[Recording], believed: TurnNumbers) -> Fit:
    """The numbers that explain the recordings best."""
    centre = beliefs.unknowns(believed, len(recordings))
    found = []
    for turned in model.readings(recordings):
        pulses = _thinned(Pulses.of(recordings, turned))
        found.append((_deepest(centre, pulses), pulses))
    best, pulses = min(found, key=lambda each: each[0].cost)
    residual = model.headings(best.at[None], pulses)[0] - pulses.heading_deg
    errors = np.sqrt(np.diag(best.covariance))
    further, _ = model.of_pulses(best.at[None])
    return Fit(
        beliefs.numbers(best.at),
        float(np.sqrt(np.nanmean(residual**2))),
        float(np.sqrt(np.mean(further**2))),
        TurnNumbers(*errors[:8].tolist()),
    )


def _deepest(centre: FloatArray, pulses: Pulses) -> Valley:
    tried = []
    for lie, caster in _STARTS:
        for brisk in (False, True):
            start = centre.copy()
            start[model.LIE], start[model.CASTER] = lie, caster
            if brisk:
                start[[model.ACCELERATE, model.BREAKAWAY]] = _BRISK
            tried.append(_valley_below(start, centre, pulses, *_COARSE))
    tried.sort(key=lambda valley: valley.cost)
    sharp = (_valley_below(valley.at, centre, pulses, *_SHARP) for valley in tried[:_BEST])
    return min(sharp, key=lambda valley: valley.cost)


def _thinned(p: Pulses) -> Pulses:
    times, headings, away = (a[:, ::_EVERY].copy() for a in (p.time_s, p.heading_deg, p.away_rad))
    return replace(p, time_s=times, heading_deg=headings, away_rad=away)


def _valley_below(
    start: FloatArray, centre: FloatArray, pulses: Pulses, noise_deg: float, rounds: int
) -> Valley:
    """The end of a descent from `start`; `centre`: the prior means of the unknowns."""
    many = len(pulses.seconds)
    bounds = beliefs.bounds(many)
    known = np.isfinite(pulses.heading_deg)
    wanted = np.concatenate((pulses.heading_deg[known] / noise_deg, np.zeros(many)))
    # The chair's unknowns are nudged one by one; the pulses' own of each kind all at once, because
    # each moves its own samples only.
    chair = np.eye(model.UNKNOWNS, len(centre))
    column = np.arange(len(centre))
    late = column >= len(centre) - many
    further = (column >= model.UNKNOWNS) & ~late
    nudges = _NUDGE * np.vstack([np.zeros(len(centre)), chair, further, late])
    of_pulse = np.concatenate([np.nonzero(known)[0], np.arange(many)])[:, None] == np.arange(many)

    def look(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        headings = model.headings(at + nudges, pulses)[:, known] / noise_deg
        seen = np.hstack((headings, model.excess_dps(at + nudges, pulses) / _STUCK_DPS))
        slopes = ((seen[1:] - seen[0]) / _NUDGE).T
        chairs, further, late = np.split(slopes, [model.UNKNOWNS, model.UNKNOWNS + 1], axis=1)
        slopes = np.hstack([chairs, further * of_pulse, late * of_pulse])
        residual = np.concatenate((seen[0] - wanted, (at - centre) / bounds.size))
        return residual, np.vstack([slopes, np.diag(1.0 / bounds.size)])

    return descend(look, len(wanted), start, bounds, rounds)
