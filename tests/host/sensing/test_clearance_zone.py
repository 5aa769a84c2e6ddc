"""The host checks the board's stopping distance: the board's settings count, not defaults."""

from __future__ import annotations

import io
import math
import re
import struct
from pathlib import Path

import numpy as np
import pytest

import gazechair.sensing.clearance.zone
from gazeboard.core.obstacles import Obstacles
from gazeboard.io.settings import Settings
from gazechair.base.footprint import Footprint
from gazechair.board.zone import NOT_KNOWN, BoardZone, ReceivedZone
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.clearance.movers import Movers
from gazechair.sensing.clearance.reach import LidarReach
from gazechair.sensing.clearance.standing import Approach
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar.blind import BLIND, SEEN
from gazechair.sensing.lidar.child import read_zones
from gazechair.sensing.lidar.scan import ChairView
from gazechair.sensing.lidar.zone_message import pack, unpack
from gazelink import codes, zone
from gazesim.rooms import Person, Room
from gazesim.zone import reported_zone, zone_of
from lidarviews import HALL, LOOK_S, NOISE_M, ORIGIN, points_of, view_of

F = codes.DIR_FORWARD
WEAK = {"p5_1_brake_mm_s2": 200, "reaction_ms": 1000}


def weak() -> Settings:
    settings = Settings()
    for name, value in WEAK.items():
        setattr(settings, name, value)
    return settings


def test_the_zone_is_the_boards_own_stopping() -> None:
    # By the promise's words: 556 mm/s for 490 ms, and 556^2 / 2a, and the margin.
    assert zone_of().far[F] == pytest.approx(0.556 * 0.49 + 0.556**2 / (2 * 0.5) + 0.1, abs=0.003)
    assert zone_of(weak()).far[F] == pytest.approx(0.556 + 0.556**2 / (2 * 0.2) + 0.1, abs=0.003)
    assert (zone_of(weak()).far > zone_of().far).all()
    assert zone_of().far[codes.DIR_LEFT] == pytest.approx(
        (910 / 16) * 0.49 + (910 / 16) ** 2 / (2 * 150) + 3, abs=0.1
    )


def test_the_time_is_the_boards_own_too_and_goes_on_beyond_full_speed() -> None:
    for speed in (0.0, 0.2, -0.3, 0.5, 1.0):
        assert zone_of().time_s(speed) == pytest.approx(0.49 + abs(speed) / 0.5, abs=0.006)
        assert zone_of(weak()).time_s(speed) == pytest.approx(1.0 + abs(speed) / 0.2, abs=0.02)


def test_no_braking_figure_is_written_here() -> None:
    text = Path(gazechair.sensing.clearance.zone.__file__).read_text()
    assert "settings_table" not in text
    code = re.sub(r'"""[\s\S]*?"""', "", text)
    assert set(re.findall(r"(?<![\w.])\d+\.?\d*", code)) <= {"0", "0.0", "1", "1.0", "2", "3"} | {
        "1000.0",
        "16.0",
    }


@pytest.mark.parametrize("way_m", [0.8, 1.0, 1.3, 1.8])
def test_someone_who_stands_is_neared_more_slowly_by_a_chair_that_brakes_less(way_m: float) -> None:
    usual, less = (Approach(one.of(F)) for one in (zone_of(), zone_of(weak())))
    assert less.blocked_within_m > usual.blocked_within_m + 0.5
    speeds = []
    for approach, settings in ((usual, Settings()), (less, weak())):
        begin = Obstacles(settings)._stopping[F]
        reported_mm = 1000.0 * approach.reported_m(way_m)
        permitted = [n for n, least in enumerate(begin.begin) if least <= reported_mm]
        speed = begin.speed(begin.permille[permitted[-1]]) / 1000.0 if permitted else 0.0
        speeds.append(min(speed, 0.334))
        reaction_s, brake = (0.49, 0.5) if settings.reaction_ms == 350 else (1.0, 0.2)
        if speeds[-1]:
            own_m = speeds[-1] * reaction_s + speeds[-1] ** 2 / (2 * brake)
            assert own_m + reaction_s + (speeds[-1] - 0.05) / brake <= way_m + 0.01
    assert speeds[1] <= speeds[0]
    assert speeds[1] < speeds[0] or way_m > 1.5


def test_someone_who_walks_counts_for_as_long_as_the_chair_takes_to_stop() -> None:
    person = Room("hall", HALL, people=[Person(((3.5, 0.0),))])
    nearest = {}
    for name, stops in (("usual", zone_of()), ("weak", zone_of(weak())), ("unknown", UNKNOWN)):
        movers = Movers(ORIGIN)
        movers.zone = stops
        person.people[0].x_m = 3.5
        for look in range(1, 13):
            person.people[0].x_m -= LOOK_S
            points = points_of(person, np.random.default_rng(look), NOISE_M)
            coming = movers.update(points, look * LOOK_S)
        nearest[name] = float(coming[:, 0].min())
    assert nearest["weak"] < nearest["usual"] - 0.4
    assert nearest["unknown"] == pytest.approx(ORIGIN[0], abs=0.01)


def beam(distance_m: float) -> ChairView:
    ways = np.radians(np.arange(-180.0, 180.0, 0.1125))
    ranges = np.full(len(ways), 4.0)
    ranges[int(np.argmin(np.abs(ways)))] = distance_m
    found = np.column_stack((np.cos(ways), np.sin(ways))) * ranges[:, None] + ORIGIN
    return ChairView(found, np.full(360, SEEN, dtype=np.uint8), ORIGIN, 1.0, codes.SIMULATED)


def test_one_beam_counts_as_far_as_the_chair_takes_to_stop() -> None:
    at_m = 0.70 + 1.0 - ORIGIN[0]  # a metre before the foot rests
    ways = []
    for stops in (zone_of(), zone_of(weak()), UNKNOWN):
        reach = LidarReach(Footprint())
        reach.use(stops)
        ways.append(reach.update(beam(at_m))[F])
    assert ways[0] > 2.0
    assert ways[1] == pytest.approx(1.0, abs=0.02)
    assert ways[2] == pytest.approx(1.0, abs=0.02)


def test_a_blind_place_blocks_what_sweeps_it_while_stopping() -> None:
    evaluator = Evaluator(Footprint(), [ORIGIN])
    states = np.full(360, SEEN, dtype=np.uint8)
    left_of_it = 180 + 40
    states[left_of_it : left_of_it + 4] = BLIND
    found = {}
    for name, stops in (("usual", zone_of()), ("weak", zone_of(weak())), ("unknown", UNKNOWN)):
        evaluator.zone = stops
        view = ChairView(np.zeros((0, 2)), states, ORIGIN, 1.0, codes.SIMULATED)
        found[name] = evaluator((view,))["blocked"]
    for less, more in (("usual", "weak"), ("weak", "unknown")):
        assert found[less] & ~found[more] == 0


def test_another_zone_counts_with_the_next_call_also_for_a_view_that_was_judged() -> None:
    evaluator = Evaluator(Footprint(), [ORIGIN])
    evaluator.zone = zone_of()
    view = beam(0.70 + 1.0 - ORIGIN[0])
    for at_s in (1.0, 1.1, 1.2):
        free = evaluator((ChairView(view.points_m, view.states, ORIGIN, at_s, codes.SIMULATED),))
    assert free["forward_mm"] > 900
    room = Room("hall", HALL, people=[Person(((1.9, 0.0),))])
    standing = view_of(points_of(room, np.random.default_rng(1)), 1.3)
    before = evaluator((standing,))["forward_mm"]
    assert before > 0
    evaluator.zone = zone_of(weak())
    assert evaluator((standing,))["forward_mm"] == 0
    evaluator.zone = UNKNOWN
    assert evaluator((standing,))["forward_mm"] == 0


def test_as_long_as_the_board_has_not_said_nobody_is_neared() -> None:
    assert (UNKNOWN.far == math.inf).all()
    approach = Approach(UNKNOWN.of(F))
    assert [approach.reported_m(way_m) for way_m in (0.1, 1.0, 9.0)] == [0.0, 0.0, 0.0]
    assert approach.reported_m(math.inf) == math.inf


def test_what_no_chair_does_is_refused() -> None:
    good = list(reported_zone().points)
    falls = b"".join(reversed([good[0][k : k + 8] for k in range(0, zone.SIZE, 8)]))
    never = struct.pack(zone.POINT, 0, 0, 0, 0) * zone.POINTS
    for bad in (b"", good[0][:-1], falls, never, b"\xff" * zone.SIZE):
        with pytest.raises(ValueError, match="zone"):
            StopZone([bad, *good[1:]])
    with pytest.raises(ValueError, match="zone"):
        StopZone(good[:3])


def test_the_child_understands_what_the_daemon_says() -> None:
    for reported in (reported_zone(), reported_zone(weak())):
        line = pack(reported)
        assert len(line) < 1000
        assert (unpack(line + b"\n").far == StopZone(reported.points).far).all()
    for line in (pack(NOT_KNOWN), b"", b"{", b"[1, 2]", b'["zz"]', b"7", b"\xff\n", b'["00"]'):
        assert unpack(line).far[F] == math.inf


def test_the_child_hears_until_its_parent_is_gone() -> None:
    evaluator = Evaluator(Footprint(), [ORIGIN])
    read_zones(
        io.BytesIO(pack(reported_zone(weak())) + b"\n" + pack(reported_zone()) + b"\n"), evaluator
    )
    assert (evaluator.zone.far == zone_of().far).all()
    read_zones(io.BytesIO(pack(NOT_KNOWN) + b"\n"), evaluator)
    assert evaluator.zone.of(F) is None


def test_all_directions_make_a_zone_and_each_change_is_told_once() -> None:
    received = ReceivedZone()
    usual, other = reported_zone().points, reported_zone(weak()).points
    assert [received.received(at, usual[at]) for at in (0, 1, 1, 2)] == [None] * 4
    assert received.received(3, usual[3]) == BoardZone(usual)
    assert [received.received(at, usual[at]) for at in range(4)] == [None] * 4
    found = received.received(0, other[0])
    assert found is not None
    assert found.points == (other[0], *usual[1:])
    assert received.received(4, usual[0]) is None
    received.forget()
    assert [received.received(at, usual[at]) for at in range(3)] == [None] * 3
    assert received.received(3, usual[3]) == BoardZone(usual)
