"""Checks a result of tuning: refuses poor data and implausible numbers."""

from __future__ import annotations

from collections.abc import Sequence

from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.identify import Fit
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazelink.settings_table import PROFILES, TABLE, index_of

_RESIDUAL_DEG = 0.25
_RESIDUAL_SHARE = 0.04  # of the mean turn per pulse
_UNEVEN = 0.1  # a very uneven floor makes half of it
_TURNED_DEG = 2.0  # on average
_SURE = 0.25  # standard error of a full speed, as a share
_APART = 3.0  # left and right
_FITS = 1.7  # found and expected speeds of a profile differ: by load, battery and floor
# A chair may have no deadband, stiction or casters' turn at all.
_MAY_BE_NONE = (
    *("tuned", "deadband_permille", "breakaway_q4_dps"),
    *("caster_q4_deg", "caster_way_q4_deg"),
)
_OTHER = 1.35  # another profile is named only when it fits this much better


def judge(recordings: Sequence[Recording], fit: Fit) -> None:
    """Raise TuneError with the reason when the data is poor."""
    turned = [abs(r.turned_deg) for r in recordings]
    mean = sum(turned) / len(turned)
    if mean < _TURNED_DEG:
        raise TuneError(
            "the chair turned only {deg} degrees a pulse; is something in its way, or a slower"
            " profile selected than the chair turns with?",
            "tune_little",
            deg=round(mean, 1),
        )
    if fit.residual_deg > max(_RESIDUAL_DEG, _RESIDUAL_SHARE * mean) or fit.uneven > _UNEVEN:
        raise TuneError(
            "the chair's turns do not repeat (they differ by {percent} % from each other, and by"
            " {deg} degrees from any one chair's); repeat on an even, firm floor, with nobody"
            " touching the chair",
            "tune_uneven",
            percent=round(100 * fit.uneven),
            deg=round(fit.residual_deg, 1),
        )
    n = fit.numbers
    if max(fit.spread.left_dps, fit.spread.right_dps) > _SURE:
        raise TuneError(
            "the pulses do not show how fast the chair turns; give it more space and repeat",
            "tune_vague",
        )
    if not 1 / _APART < n.left_dps / n.right_dps < _APART:
        raise TuneError(
            "it turns {left} degrees/s to the left and {right} to the right; is a brake dragging,"
            " or a caster caught?",
            "tune_sides",
            left=round(n.left_dps),
            right=round(n.right_dps),
        )
    _within_limits(n)


def _within_limits(numbers: TurnNumbers) -> None:
    for name, value in numbers.rows(PROFILES[0]).items():
        _, _, low, high = TABLE[index_of(name)]
        if name.endswith(_MAY_BE_NONE):
            continue
        if not low < value < high:
            what = name.partition("_")[2].partition("_")[2]
            raise TuneError(
                "{what} would be {value}, at or beyond the limit {low}..{high}; repeat on an even"
                " floor; if it stays, the chair is unlike any this was made for",
                "tune_limit",
                what=what,
                value=value,
                low=low,
                high=high,
            )


def fits_profile(numbers: TurnNumbers, profile: str) -> None:
    """Raise TuneError when the chair does not turn like `profile`; it names a better match."""
    off = _off(numbers, profile)
    if off <= _FITS:
        return
    best = min(PROFILES, key=lambda other: _off(numbers, other))
    text = (
        "it turns {left} degrees/s to the left and {right} to the right: not as profile {profile}"
        " does"
    )
    left, right = round(numbers.left_dps), round(numbers.right_dps)
    if _off(numbers, best) * _OTHER < off:
        text += ", rather as {best}; select the profile on the chair and name the same one here"
        key = "tune_other_profile"
    else:
        text += ", nor any other; check the wiring of the turn channel"
        key, best = "tune_no_profile", ""
    raise TuneError(text, key, left=left, right=right, profile=profile, best=best)


def _off(numbers: TurnNumbers, profile: str) -> float:
    """Ratio of the speeds to those observed in that profile: 1 = equal, 2 = twice or half."""
    seen = TurnNumbers.default(profile)
    ratio = (numbers.left_dps / seen.left_dps * numbers.right_dps / seen.right_dps) ** 0.5
    return float(max(ratio, 1 / ratio))
