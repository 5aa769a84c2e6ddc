"""The measured speed as sent to the web pages."""

from __future__ import annotations

from gazechair.base.latest_value import Entry
from gazechair.sensing.odometry.doubts import UNSURE
from gazechair.sensing.odometry.estimate import Estimate

OLD_S = 0.5
_UNSURE_M_S = 0.15  # a standard deviation


def shown(entry: Entry[Estimate] | None, now_s: float) -> dict[str, float] | None:
    """Speeds with uncertainty and age; None: not known, stale or doubted."""
    if entry is None or now_s - entry.born_s > OLD_S:
        return None
    estimate = entry.value
    if UNSURE.intersection(estimate.doubts) or estimate.speed_sigma_m_s > _UNSURE_M_S:
        return None
    return {
        "m_s": round(estimate.speed_m_s, 3),
        "deg_s": round(estimate.yaw_rate_deg_s, 1),
        "sigma_m_s": round(estimate.speed_sigma_m_s, 3),
        "age_s": round(now_s - entry.born_s, 3),
    }
