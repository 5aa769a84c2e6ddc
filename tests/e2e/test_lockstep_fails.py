"""What driving does not need may fail: the chair drives on, and the page says what is wrong."""

from __future__ import annotations

import pytest

from gazechair.base.health import DEGRADED, LOST
from gazechair.base.reasons import DRIVES, REASONS
from gazesim.lockstep_chair import Lockstep

pytestmark = pytest.mark.costly


@pytest.mark.parametrize(
    ("part", "state", "reason", "shown"),
    [
        ("camera", LOST, "camera_lost", "camera_lost"),
        ("host", DEGRADED, "host_hot", "host_hot"),
        ("host", DEGRADED, "host_slow", "host_slow"),
        ("log", DEGRADED, "log_full", ""),
        ("alerts", LOST, "alerts_lost", ""),
        ("input gamepad", LOST, "plugin_ended", ""),
    ],
)
def test_it_drives_without_what_driving_does_not_need(
    driving: Lockstep, part: str, state: str, reason: str, shown: str
) -> None:
    """`shown`: on the driver's page; "" = what it showed before."""
    assert driving.host is not None
    usual = driving.page.shown["message"]
    assert usual in ("ok", "untuned")
    driving.host.parts.part(part).set(state, reason)
    for _ in range(400):
        driving.one_ms()
        assert not driving.neutral(), driving.why()
    assert driving.page.shown["message"] == (shown or usual)
    driving.page.release()
    driving.until(driving.neutral, 400)
    driving.comes_to_rest()
    driving.needs_a_new_press()
    assert REASONS[reason].then == DRIVES
