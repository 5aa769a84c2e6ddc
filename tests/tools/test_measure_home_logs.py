"""The evaluator of the public logs is right: the references themselves score what was published."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gazesetup
from gazemeasure import carmen_log
from gazemeasure.carmen_log import Frame, NoDataError
from gazemeasure.home import logs
from gazemeasure.report import Report


def frames_of(name: str) -> list[Frame]:
    try:
        return carmen_log.read(name)
    except NoDataError as error:
        pytest.skip(str(error))


def test_the_intel_key_frames_own_poses_score_as_published() -> None:
    frames = frames_of(carmen_log.INTEL)
    assert len(frames) == 910
    reference = np.array([frame.reference for frame in frames])
    errors_m = carmen_log.intel_relations_m(logs.times_of(frames), reference)
    assert (errors_m.mean(), errors_m.std()) == pytest.approx((0.126, 0.118), abs=0.001)


def test_a_track_that_is_only_moved_and_turned_has_no_error() -> None:
    track = np.random.default_rng(1).uniform(-5.0, 5.0, (40, 2))
    turn = np.array(((0.6, -0.8), (0.8, 0.6)))
    moved = track @ turn + np.array((3.0, -2.0))
    assert carmen_log.position_rmse_m(moved, track) == pytest.approx(0.0, abs=1e-9)
    moved[::2, 0] += 0.2
    assert carmen_log.position_rmse_m(moved, track) == pytest.approx(0.1, abs=0.01)


def test_the_first_minutes_of_fr079_become_a_map() -> None:
    frames = frames_of(carmen_log.FR079)[:400]
    mapper, taken = logs.map_fr079(frames)
    reference = np.array([frames[number].reference[:2] for number in taken])
    poses = logs.poses_of(mapper)
    assert carmen_log.position_rmse_m(poses[:, :2], reference) < 0.1


def test_without_the_logs_the_report_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    monkeypatch.setenv("GAZECHAIR_DATA", str(tmp_path))
    report = Report("home")
    logs.measure(report, quick=True)
    assert "not measured" in report.notes[0]


def test_a_rival_that_cannot_be_had_is_a_note_and_no_row(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> Path:
        raise gazesetup.NotAvailable("icp-slam is missing")

    monkeypatch.setattr(gazesetup, "ensure_icp_slam", missing)
    report = Report("home")
    nothing = np.zeros((0, 2))
    frames = [Frame(float(at), nothing, np.zeros(180), np.zeros(3)) for at in range(2)]
    logs._add_rival(report, frames, 0.1)
    assert (report.figures, report.notes) == ([], ["icp-slam not measured: icp-slam is missing"])
