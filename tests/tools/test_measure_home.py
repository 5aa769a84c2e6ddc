"""The benchmark of knowing the home: odometry on a part of a public log, and one short drive."""

from __future__ import annotations

import numpy as np
import pytest

from gazemeasure import carmen_log, home_odometry
from gazemeasure.home_drives import Job, drive
from gazemeasure.report import Report


def test_a_public_log_without_wheel_encoders() -> None:
    try:
        frames = carmen_log.read(carmen_log.FR079)[:600]
    except carmen_log.NoDataError as error:
        pytest.skip(str(error))
    assert home_odometry.rmse_m(frames, 1)[0] < 0.15


def test_an_absent_log_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GAZECHAIR_DATA", "/nowhere")
    report = Report("home")
    home_odometry.measure(report, quick=True)
    assert not report.figures
    assert "/nowhere" in report.notes[0]


def test_a_short_drive_is_judged_by_the_truth() -> None:
    found = drive(Job(4, 16.0, "one lidar"))
    assert found.way_m > 0.5
    assert found.end_m < 0.03
    assert found.age_s.max() < 0.1
    assert np.percentile(np.abs(found.speed_m_s), 90) < 0.05
