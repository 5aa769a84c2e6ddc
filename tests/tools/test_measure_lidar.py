"""The figures of the lidar's stream, on small samples; the live ones are left to the benchmark."""

from __future__ import annotations

import pytest

from gazemeasure import lidar_damage, lidar_process


def test_damage_is_counted() -> None:
    clean = lidar_damage.count_undetected(20_000, 0.0, 0.0, seed=3)
    assert (clean.undetected, clean.reported_share) == (0, 0.0)
    assert clean.decoded == pytest.approx(clean.sent, abs=4)
    lossy = lidar_damage.count_undetected(20_000, 0.001, 0.0, seed=3)
    assert lossy.undetected <= 1
    assert lossy.reported_share == pytest.approx(0.08, abs=0.01)
    assert 0.9 < lossy.decoded / lossy.sent < 0.93


def test_a_wrong_point_counts_for_one_pass_of_the_mirror() -> None:
    assert lidar_damage.longest_extension(60, seed=2)[0] == 1


def test_decoding_costs_something() -> None:
    assert all(share > 0.0 for share in lidar_damage.decode_share(0.5))


def test_the_process_evaluates_and_costs_something() -> None:
    share, rate_hz = lidar_process.core_share(1.0)
    assert share > 0.0
    assert rate_hz > 0.0
