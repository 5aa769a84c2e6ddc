"""What a ride takes of a core: of the time of the ride alone, whatever was before and after."""

from __future__ import annotations

import pytest

from gazemeasure.go import process
from gazemeasure.go.process import Ride


def test_only_the_time_of_the_ride_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    taken_s = {1: 50.0, 2: 7.0}
    now_s = 100.0

    def cpu_s(pid: int) -> float:
        if pid not in taken_s:
            raise OSError
        return taken_s[pid]

    monkeypatch.setattr(process, "cpu_s", cpu_s)
    with Ride(lambda: [1, 2, 3], lambda: now_s) as ride:
        assert ride is not None
        now_s += 10.0
        taken_s[1] += 4.0
        del taken_s[2]  # it has ended
        taken_s[3] = 1.5  # it has begun
    now_s += 1000.0  # pictures of the arrival
    taken_s[1] += 1.0
    assert ride.share == pytest.approx(0.55)
