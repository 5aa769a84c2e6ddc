"""The figures of the lidar's stream, on small samples; the live ones are left to the benchmark."""

from __future__ import annotations

import pytest

from gazemeasure.lidar import damage, stream
from gazemeasure.lidar import process as lidar_process
from gazemeasure.report import Report


def test_damage_is_counted() -> None:
    clean = damage.count_undetected(20_000, 0.0, 0.0, seed=3)
    assert (clean.undetected, clean.reported_share) == (0, 0.0)
    assert clean.decoded == pytest.approx(clean.sent, abs=4)
    lossy = damage.count_undetected(20_000, 0.001, 0.0, seed=3)
    assert lossy.undetected <= 1
    assert lossy.reported_share == pytest.approx(0.08, abs=0.01)
    assert 0.9 < lossy.decoded / lossy.sent < 0.93


def test_a_wrong_point_counts_for_one_pass_of_the_mirror() -> None:
    assert damage.longest_extension(60, seed=2)[0] == 1


def test_only_bytes_that_the_port_lost_excuse_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def figures(*runs: tuple[int, int]) -> Report:
        left = list(runs)

        def run(_seconds: float, _busy: bool) -> stream.Live:
            restarts, lost = left.pop(0)
            return stream.Live([4.0], 0, 0, 0, restarts, lost)

        monkeypatch.setattr(stream, "_run", run)
        report = Report("")
        stream._live(report, 1.0)
        return report

    assert figures((0, 0), (0, 0)).ok
    restarted = figures((1, 0), (0, 0), (0, 0))
    assert not restarted.ok
    lost = figures((1, 90), (0, 0), (0, 0))
    assert lost.ok
    rows = [one.value for one in lost.figures if one.name.startswith("  runs until")]
    assert rows == [2, 1]


def test_decoding_costs_something() -> None:
    assert all(share > 0.0 for share in damage.decode_share(0.5))


def test_the_process_evaluates_and_costs_something() -> None:
    share, rate_hz = lidar_process.core_share(1.0)
    assert share > 0.0
    assert rate_hz > 0.0
