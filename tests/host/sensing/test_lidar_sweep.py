"""Assembling turns: always one whole turn, the newest of each angle, its age never understated."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.sensing.lidar.nodes import Nodes
from gazechair.sensing.lidar.scan import Scan
from gazechair.sensing.lidar.sweep import NODE_PERIOD_S, Sweep
from gazelink import codes

PER_TURN = 1600


def piece(first: int, count: int, distance_m: float = 1.0, drop_starts: bool = False) -> Nodes:
    index = np.arange(first, first + count)
    raw_deg = index % PER_TURN * 360.0 / PER_TURN
    return Nodes(
        angles_deg=(180.0 - raw_deg) % 360.0 - 180.0,
        distances_m=np.full(count, distance_m),
        starts=(index % PER_TURN == 0) & (not drop_starts),
        backlog=np.arange(count - 1, -1, -1),
    )


def run(sweep: Sweep, first: int, count: int, step: int, distance_m: float = 1.0) -> Scan | None:
    scan = None
    for at in range(first, first + count, step):
        size = min(step, first + count - at)
        scan = sweep.add(piece(at, size, distance_m), (at + size) * NODE_PERIOD_S)
    return scan


@settings(deadline=None)
@given(st.integers(20, 2000), st.integers(2 * PER_TURN, 4 * PER_TURN))
def test_after_two_turns_every_scan_is_one_whole_turn(step: int, count: int) -> None:
    scan = run(Sweep(codes.SIMULATED), 0, count, step)
    assert scan is not None
    assert PER_TURN <= len(scan) <= PER_TURN + 1
    assert len(np.unique(np.floor(scan.angles_deg))) == 360


@settings(deadline=None)
@given(st.integers(20, 500), st.integers(2 * PER_TURN, 4 * PER_TURN))
def test_its_age_is_that_of_its_oldest_measurement(step: int, count: int) -> None:
    scan = run(Sweep(codes.SIMULATED), 0, count, step)
    assert scan is not None
    age_s = count * NODE_PERIOD_S - scan.acquired_s
    assert PER_TURN * NODE_PERIOD_S - 0.001 <= age_s <= PER_TURN * NODE_PERIOD_S + 0.001


def test_the_newest_measurement_of_each_angle_wins() -> None:
    sweep = Sweep(codes.SIMULATED)
    run(sweep, 0, 2 * PER_TURN, 400, distance_m=2.0)
    scan = run(sweep, 2 * PER_TURN, PER_TURN // 2, 400, distance_m=1.0)
    assert scan is not None
    right = (scan.angles_deg < 0) & (scan.angles_deg > -179)  # the mirror goes right first
    left = scan.angles_deg > 1
    assert np.all(scan.distances_m[right] == 1.0)
    assert np.all(scan.distances_m[left] == 2.0)


def test_a_lost_start_flag_makes_the_scan_older_not_wrong() -> None:
    sweep = Sweep(codes.SIMULATED)
    run(sweep, 0, 2 * PER_TURN, 400)
    start = 2 * PER_TURN
    scan = sweep.add(piece(start, PER_TURN, drop_starts=True), (start + PER_TURN) * NODE_PERIOD_S)
    assert scan is not None
    assert (start + PER_TURN) * NODE_PERIOD_S - scan.acquired_s == pytest.approx(0.2, abs=0.001)


def test_a_lidar_that_never_sends_a_start_flag_costs_no_memory() -> None:
    sweep = Sweep(codes.SIMULATED)
    for number in range(200):
        scan = sweep.add(piece(number * 400, 400, drop_starts=True), number * 0.025)
        assert scan is not None
        assert len(scan) <= 8000
    assert sweep.turns == 0


def test_nothing_in_nothing_out() -> None:
    assert Sweep(codes.SIMULATED).add(piece(0, 0), 1.0) is None


def test_after_a_pause_the_old_half_keeps_its_age() -> None:
    sweep = Sweep(codes.SIMULATED)
    run(sweep, 0, 3 * PER_TURN, 400)
    scan = sweep.add(piece(3 * PER_TURN, 800), 10.0)
    assert scan is not None
    assert scan.acquired_s < 1.0


def without(nodes: Nodes, from_deg: float, to_deg: float) -> Nodes:
    """What is left; a turn whose start was lost starts with what came next, as in dense mode."""
    kept = (nodes.angles_deg < from_deg) | (nodes.angles_deg >= to_deg)
    starts = nodes.starts[kept]
    starts[0] |= nodes.starts[0]
    return Nodes(nodes.angles_deg[kept], nodes.distances_m[kept], starts, nodes.backlog[kept])


def add_turn(sweep: Sweep, turn: int, nodes: Nodes) -> Scan:
    scan = sweep.add(nodes, (turn + 1) * PER_TURN * NODE_PERIOD_S)
    assert scan is not None
    return scan


def at(scan: Scan, from_deg: float, to_deg: float) -> set[float]:
    inside = (scan.angles_deg >= from_deg) & (scan.angles_deg < to_deg)
    return {float(distance) for distance in scan.distances_m[inside]}


@pytest.mark.parametrize(
    ("arc", "age_s"), [((40.0, 50.0), 0.114), ((-10.0, 0.5), 0.2), ((-180.0, -170.0), 0.153)]
)
def test_degrees_that_were_lost_show_both_turns_before_and_only_once(
    arc: tuple[float, float], age_s: float
) -> None:
    inner = (arc[0], arc[1] - 0.5)
    sweep = Sweep()
    for turn, distance_m in enumerate((1.0, 2.0, 3.0)):
        add_turn(sweep, turn, piece(turn * PER_TURN, PER_TURN, distance_m))
    lost = add_turn(sweep, 3, without(piece(3 * PER_TURN, PER_TURN, 4.0), *arc))
    assert at(lost, *inner) == {3.0, 2.0}
    assert at(lost, 100.0, 120.0) == {4.0}
    assert 4 * PER_TURN * NODE_PERIOD_S - lost.acquired_s == pytest.approx(age_s, abs=0.001)
    again = add_turn(sweep, 4, without(piece(4 * PER_TURN, PER_TURN, 5.0), *arc))
    assert at(again, *inner) == set()
    back = add_turn(sweep, 5, piece(5 * PER_TURN, PER_TURN, 6.0))
    assert at(back, *inner) == {6.0}


@settings(deadline=None)
@given(st.integers(0, 1 << 32), st.booleans())
def test_whatever_is_lost_a_scan_is_the_plain_formula(seed: int, jumps: bool) -> None:
    random = np.random.default_rng(seed)
    sweep, pieces = Sweep(), [[np.zeros((3, 0))]] * 4
    for number in range(24):
        first = number * 400
        nodes = piece(first, 400, random.uniform(1.0, 5.0))
        raw_deg = -nodes.angles_deg % 360.0 + random.uniform(-0.1, 0.1, 400) * jumps
        lost_deg = random.uniform(0.0, 360.0)
        kept = (raw_deg - lost_deg) % 360.0 > random.choice((0.0, 3.0, 20.0))
        kept[0] = True
        angles_deg = (180.0 - raw_deg[kept]) % 360.0 - 180.0
        nodes = Nodes(angles_deg, nodes.distances_m[kept], nodes.starts[kept], nodes.backlog[kept])
        now_s = (first + 400) * NODE_PERIOD_S
        scan = sweep.add(nodes, now_s)
        times_s = now_s - nodes.backlog * NODE_PERIOD_S
        if nodes.starts[0]:
            pieces = [[], *pieces[:3]]
        pieces[0] = [*pieces[0], np.stack((angles_deg, nodes.distances_m, times_s))]
        plain = plainly([np.concatenate(turn, axis=1) for turn in pieces])
        assert scan is not None
        assert scan.angles_deg.tobytes() == plain[0].tobytes()
        assert scan.distances_m.tobytes() == plain[1].tobytes()
        assert scan.acquired_s == plain[2].min()


def plainly(turns: list[np.ndarray]) -> np.ndarray:
    """The scan of turns, newest first: the rows of all its nodes are angle, distance, time."""
    steps = (np.diff(turns[0][0]) + 180.0) % 360.0 - 180.0
    first_deg = -turns[0][0, 0] % 360.0
    reached_deg = first_deg - 360.0 * (first_deg > 355.0) - steps.sum()

    def view(back: int) -> np.ndarray:
        newer, older = turns[back : back + 2]
        newer = newer[:, -newer[0] % 360.0 <= reached_deg] if back else newer
        return np.concatenate((newer, older[:, -older[0] % 360.0 > reached_deg]), axis=1)

    def has(nodes: np.ndarray) -> np.ndarray:
        return np.bincount(np.floor(nodes[0] + 180.0).astype(int), minlength=360) > 0

    whole, before, oldest = view(0), view(1), view(2)
    filled = ~has(whole) & has(before) & has(oldest)
    again = before[:, filled[np.floor(before[0] + 180.0).astype(int)]]
    still = oldest[:, filled[np.floor(oldest[0] + 180.0).astype(int)] & (oldest[1] > 0.0)]
    still[2] = np.inf
    return np.concatenate((whole, again, still), axis=1)


def test_its_turning_rate_is_measured() -> None:
    sweep = Sweep()
    run(sweep, 0, 5 * PER_TURN, 100)
    assert sweep.rate_hz == pytest.approx(10.0, abs=0.01)
