"""The lidars together: a failure is known within 300 ms, and affects no other lidar."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest

from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar.blind import BLIND, MASKED, SEEN, Blindness
from gazechair.sensing.lidar.child import Lidar, Pipeline
from gazechair.sensing.lidar.report import Report
from gazechair.sensing.lidar.scan import ChairView, Pose, to_chair
from gazechair.sensing.lidar.stream import ByteStream
from gazelink import codes
from gazesim.s2 import S2
from lidarrig import LidarRig, wait_for

MASK = ((123.0, -123.0),)
REQUESTS = {"dense": bytes.fromhex("a58205010000000023"), "standard": b"\xa5\x20"}
FAULTS: dict[str, Callable[[S2], None]] = {
    "covered": lambda lidar: setattr(lidar.beams, "covered_deg", (0.0, 120.0)),
    "frozen": lambda lidar: setattr(lidar.beams, "frozen", True),
    "silent": lambda lidar: setattr(lidar, "stalled", True),
    "mirror": lambda lidar: setattr(lidar, "mirror_blocked", True),
    "power": lambda lidar: lidar.power_dip(),
}


class Virtual:
    """An S2 and its stream in virtual time, a millisecond a step; its bytes come every 5 ms."""

    def __init__(self, mode: str, range_m: float) -> None:
        self.device = S2(lambda angles: np.full(len(angles), range_m))
        self.device.receive(REQUESTS[mode])
        self.device.step(0.001)  # the descriptor
        self.stream = ByteStream(mode, codes.SIMULATED)
        self.blindness = Blindness()
        self.now_s = 0.0
        self.view: ChairView | None = None

    def step(self) -> None:
        self.now_s += 0.001
        if self.stream.feed(self.device.step(0.001), self.now_s):
            scan = self.stream.scan()
            self.view = scan and to_chair(scan, Pose(0.5), MASK, self.blindness)

    def usable(self, at_deg: int) -> bool:
        """True while the direction is seen, by measurements of the last 300 ms."""
        view = self.view
        if view is None or self.now_s - view.acquired_s > 0.3:
            return False
        return bool(view.states[at_deg + 180] == SEEN)

    def until(self, condition: Callable[[], bool], most_s: float) -> float:
        start_s = self.now_s
        while not condition():
            self.step()
            assert self.now_s - start_s <= most_s
        return self.now_s - start_s


CASES = [(fault, mode, 2.0) for fault in FAULTS for mode in REQUESTS]
CASES += [("covered", "dense", 12.0)]  # as in a hall, where a gap may be open space


@pytest.mark.parametrize(("fault", "mode", "range_m"), CASES)
def test_what_it_no_longer_sees_is_known_within_300_ms(
    fault: str, mode: str, range_m: float
) -> None:
    lidar = Virtual(mode, range_m)
    lidar.until(lambda: lidar.usable(60), 0.7)
    at_s = lidar.now_s + 0.017 * (1 + CASES.index((fault, mode, range_m)))  # wherever its mirror is
    lidar.until(lambda: lidar.now_s >= at_s, 0.3)
    FAULTS[fault](lidar.device)
    lidar.until(lambda: not lidar.usable(60), 0.3)
    lidar.until(lambda: lidar.now_s >= at_s + 1.0, 1.1)
    assert not lidar.usable(60)
    if fault == "covered":
        assert lidar.usable(-60)


def test_half_covered_is_seen_again_at_once() -> None:
    lidar = Virtual("dense", 3.0)
    lidar.until(lambda: lidar.usable(60), 0.7)
    lidar.device.beams.covered_deg = (0.0, 120.0)
    lidar.until(lambda: not lidar.usable(60), 0.3)
    lidar.device.beams.covered_deg = None
    lidar.until(lambda: lidar.usable(60), 0.3)


def test_speckle_and_noise_blind_nothing() -> None:
    lidar = Virtual("dense", 3.0)
    lidar.device.beams.speckle, lidar.device.beams.noise_m = 0.01, 0.03
    lidar.until(lambda: lidar.view is not None, 0.7)
    for _ in range(1000):
        lidar.step()
        assert lidar.view is not None
        assert not np.any(lidar.view.states == BLIND)


def test_one_byte_of_a_thousand_lost_leaves_most_of_the_view() -> None:
    lidar = Virtual("dense", 3.0)
    lidar.until(lambda: lidar.view is not None, 0.7)
    lidar.device.drop = 0.001
    seen = []
    for _ in range(2000):
        lidar.step()
        assert lidar.view is not None
        seen.append(np.mean(lidar.view.states[lidar.view.states != MASKED] == SEEN))
    assert np.mean(seen) > 0.95
    assert 0.03 < lidar.stream.lost_share < 0.2


class Together:
    """Two lidars, front and rear, in one pipeline with an evaluation that counts."""

    def __init__(self, folder: Path) -> None:
        self.rigs = {name: LidarRig(folder / name) for name in ("front", "rear")}
        for rig in self.rigs.values():
            rig.device.beams.noise_m = 0.004
        front = LidarConfig("s2", "front", str(folder / "front"), x_m=0.5, mask=MASK)
        rear = LidarConfig(
            "s2", "rear", str(folder / "rear"), x_m=-0.4, heading_deg=180.0, mask=MASK
        )
        self.pipeline = Pipeline((front, rear), self._evaluate, self._deliver)
        self._evaluated: tuple[ChairView, ...] = ()
        self._delivered: SimpleQueue[tuple[Report, tuple[ChairView, ...]]] = SimpleQueue()
        self.views: tuple[ChairView, ...] = ()
        self.report: Report | None = None

    def _evaluate(self, views: tuple[ChairView, ...]) -> dict[str, Any]:
        self._evaluated = views
        return {"points": sum(len(view.points_m) for view in views)}

    def _deliver(self, report: Report) -> None:
        self._delivered.put((report, self._evaluated))

    def until(self, condition: Callable[[Report], bool]) -> Report:
        def holds() -> bool:
            while self._delivered.empty():
                self.pipeline.watch()
            self.report, self.views = self._delivered.get()
            return condition(self.report)

        wait_for(holds, lambda: self.report)
        assert self.report is not None
        return self.report

    def close(self) -> None:
        self.pipeline.stop()
        for rig in self.rigs.values():
            rig.close()


def test_two_lidars_are_judged_together_and_one_may_fail(tmp_path: Path) -> None:
    both = Together(tmp_path)
    try:
        both.pipeline.start()
        report = both.until(
            lambda r: all(one.state == "ok" and one.acquired_s is not None for one in r.lidars)
        )
        assert report.acquired_s == min(one.acquired_s or 0.0 for one in report.lidars)
        assert report.source == codes.SIMULATED
        assert report.evaluation is not None
        assert report.evaluation["points"] > 4000
        assert [len(view.points_m) > 2000 for view in both.views] == [True, True]
        # The rear one looks back: it sees there what it has before it.
        assert both.views[1].points_m[:, 0].min() == pytest.approx(-3.4, abs=0.05)
        assert [view.states[180] == MASKED for view in both.views] == [False, True]
        assert all(one.coverage == 1.0 for one in report.lidars)

        both.rigs["rear"].unplug()
        report = both.until(lambda r: r.lidars[1].state == "lost")
        assert report.lidars[0].state == "ok"
        assert report.acquired_s == report.lidars[0].acquired_s
        assert both.views[0].points_m[:, 0].max() == pytest.approx(3.5, abs=0.1)
        assert len(both.views[1].points_m) == 0
        assert set(both.views[1].states) == {BLIND, MASKED}
        assert not np.any(both.views[0].states == BLIND)

        both.rigs["front"].unplug()
        report = both.until(lambda r: r.lidars[0].state == "lost")
        assert (report.acquired_s, report.source, report.evaluation) == (None, None, None)
        for rig in both.rigs.values():
            rig.plug()
        both.until(lambda r: all(one.state == "ok" for one in r.lidars))
    finally:
        both.close()


def test_a_thread_that_does_not_come_back_is_named(tmp_path: Path) -> None:
    both = Together(tmp_path)
    try:
        assert both.pipeline.hanging() is None
        both.pipeline.lidars[1].reader.alive_s -= 60.0
        assert both.pipeline.hanging() == "rear"
    finally:
        both.close()


def test_a_report_survives_its_journey(tmp_path: Path) -> None:
    both = Together(tmp_path)
    try:
        both.pipeline.start()
        report = both.until(lambda r: r.acquired_s is not None)
        assert Report.unpack(report.pack()) == report
    finally:
        both.close()


def test_one_that_delivers_nothing_sees_nothing_however_narrow_its_view() -> None:
    config = LidarConfig(kind="s2", heading_deg=0.5, mask=((14.0, 10.0),))
    states = Lidar(config, lambda: None).view.states
    assert (states == BLIND).sum() == 3
    assert (states == MASKED).sum() == 357


def test_without_any_scan_the_state_is_delivered_all_the_same() -> None:
    reports: list[Report] = []
    pipeline = Pipeline((LidarConfig("s2", "front", "/nowhere"),), None, reports.append)
    for count in range(1, 4):  # never started: no reports arrive by themselves
        while len(reports) < count:
            pipeline.watch()
    assert [one.lidars[0].state for one in reports] == ["starting"] * 3
    assert [one.acquired_s for one in reports] == [None] * 3


def endless(one: Callable[[], None]) -> None:
    while True:
        one()


def test_what_fails_on_a_lidars_thread_is_raised_where_all_are_watched(tmp_path: Path) -> None:
    here = threading.current_thread()

    def deliver(_: Report) -> None:
        if threading.current_thread() is not here:
            raise BrokenPipeError

    pipeline = Pipeline((LidarConfig("s2", "front", str(tmp_path)),), None, deliver)
    pipeline.lidars[0].reader.start()  # it says at once that it opens its port
    try:
        with pytest.raises(BrokenPipeError):
            endless(pipeline.watch)
    finally:
        pipeline.stop()
