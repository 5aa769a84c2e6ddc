"""The arcs of the obstacles benchmark: attacks hit without the rule, and their chairs' physics."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from gazelink import codes
from gazelink.settings_table import PROFILES, profile_row
from gazemeasure.obstacles.arcs import (
    ArcRun,
    ArcTask,
    ArcTrial,
    Hold,
    _unseen_m_s,
    arc_trial,
    attack_trial,
)
from gazemeasure.obstacles.attack import KINDS, AttackedChair, attack, attacked_chair, in_view
from gazemeasure.obstacles.benchmark import _arcs
from gazemeasure.obstacles.eyes import CORNERS, FRONT
from gazemeasure.obstacles.run import Outcome, fastest
from gazemeasure.report import Report
from gazemeasure.turn.board import settings_with
from gazesim.chair import HALF_WIDTH_M
from gazesim.rooms import Room, box

pytestmark = pytest.mark.costly


def settings_of(profile: str):
    return settings_with({"profile": PROFILES.index(profile)})


# Those hit while only the straight way and the turn on the spot were judged.
@pytest.mark.parametrize("seed", [6, 7, 16, 32])
def test_p5_an_attack_hits_by_the_hand_alone_and_not_with_the_rule(seed: int) -> None:
    profile = PROFILES[seed // 4 % len(PROFILES)]
    settings = settings_of(profile)
    what = attack(seed, profile, settings)
    hand = tuple(Hold(m.for_s, m.verb, m.linear, m.turn, m.press) for m in what.hand)
    task = ArcTask(what.room, hand, bool(seed % 2))
    alone = ArcRun(task, profile, seed, ruled=False, body=attacked_chair(seed, profile, settings))()
    assert alone.touched
    ours = attack_trial(seed, profile)
    assert ours.attack == what.kind
    assert not ours.ours.touched


# 9915: backwards beside a post, its wheels uneven; the straight path was free.
def test_p5_a_chair_that_drifts_does_not_scrape_along() -> None:
    assert not arc_trial(9915).ours.touched


# 4047: backwards with one lidar in front, a post beside the rear wheel. 151: the chair rolls out
# after the rule has seen the far side of such a post.
@pytest.mark.parametrize("seed", [4047, 151])
def test_what_no_lidar_looks_at_is_crept_into(seed: int) -> None:
    trial = arc_trial(seed)
    assert trial.ours.touched
    assert not trial.ours.collided
    assert 0.0 < trial.unseen_m_s < 0.35


class Rolls:
    """A chair that brakes by 0.3 m/s2."""

    x_m = y_m = heading_deg = speed_m_s = yaw_rate_deg_s = 0.0

    def place(self, x_m: float, y_m: float, heading_deg: float) -> None:
        pass

    def step(self, dt_s: float, stick: tuple[float, float]) -> None:
        self.speed_m_s = 0.3 if any(stick) else max(0.0, self.speed_m_s - 0.3 * dt_s)
        self.x_m += self.speed_m_s * dt_s


class Late:
    """A rule that ends the press 8 cm before the wall."""

    caps, arcs, blocked = [1000] * 4, None, 0

    def __init__(self, chair: Rolls) -> None:
        self._chair = chair

    def step(self, *_: Any) -> None:
        self.blocked = 15 if self._chair.x_m > 0.3 else 0


@pytest.mark.parametrize("steady", [True, False])
def test_a_collision_while_the_chair_rolls_out_counts(steady: bool) -> None:
    walls = (*hall(6.0), (1.03, -1.0, 1.03, 1.0))
    room = Room("wall", walls, (), start=(0.0, 0.0, 0.0))
    hold = Hold(2.5, codes.DRIVE, 1000, 0, True)
    body = Rolls()
    run: Any = ArcRun(ArcTask(room, (hold, hold), steady), "3.1", 1, body=body)
    run._rule, run._obstacles = SimpleNamespace(look=lambda _: None), Late(body)
    outcome = run()
    assert outcome.stopped
    assert outcome.collided
    assert outcome.contact_m_s == pytest.approx(math.sqrt(0.3**2 - 2 * 0.3 * 0.08), abs=0.02)
    if steady:
        assert fastest(body) == pytest.approx(outcome.contact_m_s)
    behind = ((-1.0, 0.0),)
    assert _unseen_m_s(run, behind, 7) == outcome.contact_m_s


def test_what_no_lidar_sees_is_touched_at_creep_only() -> None:
    for m_s, kept in ((0.3, True), (0.6, False)):
        report = Report("")
        _arcs(report, [ArcTrial("3.1", Outcome(touched=True), None, unseen_m_s=m_s)])
        assert report.ok == kept


def hall(h: float) -> tuple[tuple[float, float, float, float], ...]:
    """A hall's."""
    return ((-h, -h, h, -h), (h, -h, h, h), (h, h, -h, h), (-h, h, -h, -h))


def straight_beside(thing: str, linear: int, gap_m: float, even: str, side: int) -> ArcRun:
    """The hand holds the stick straight for 2.5 s, a post or a wall beside the chair."""
    profile = "3.1"
    x = 0.6 if linear > 0 else 0.2
    y = side * (HALF_WIDTH_M + gap_m + 0.03)
    walls = hall(6.0)
    if thing == "wall":
        y = side * (HALF_WIDTH_M + gap_m)
        room = Room("wall", (*walls, (-4.0, y, 4.0, y)), (), start=(0.0, 0.0, 0.0))
    else:
        post = box(x, y, 0.06, 0.06, 0.0, 1.0, "wood")
        room = Room("post", walls, (post,), start=(0.0, 0.0, 0.0))
    hold = Hold(2.5, codes.DRIVE, linear, 0, True)
    chair = AttackedChair(
        profile, "exact" if even == "both" else "uneven", settings_of(profile), even == "left"
    )
    return ArcRun(ArcTask(room, (hold,), False), profile, 1, body=chair)


@pytest.mark.parametrize(
    ("linear", "gap_m"),
    [(1000, 0.015), (1000, 0.03), (300, 0.015), (-1000, 0.008), (-1000, 0.03), (-300, 0.02)],
)
@pytest.mark.parametrize("even", ["left", "right"])
@pytest.mark.parametrize("thing", ["post", "wall"])
def test_p5_uneven_wheels_straight_beside(thing: str, linear: int, gap_m: float, even: str) -> None:
    for side in (1, -1):
        run = straight_beside(thing, linear, gap_m, even, side)
        assert not run().touched
        assert fastest(run.chair) < 0.05


@pytest.mark.parametrize("linear", [1000, -1000])
@pytest.mark.parametrize(("thing", "gap_m"), [("post", 0.025), ("post", 0.05), ("wall", 0.05)])
def test_an_even_chair_gets_away_from_what_is_close_beside(
    thing: str, gap_m: float, linear: int
) -> None:
    run = straight_beside(thing, linear, gap_m, "both", 1)
    assert not run().touched
    assert abs(run.chair.x_m) > 0.1


@pytest.mark.parametrize("seed", range(2 * len(KINDS)))
def test_the_thing_is_beside_the_chair_and_clear_of_it(seed: int) -> None:
    profile = PROFILES[seed % len(PROFILES)]
    what = attack(seed, profile, settings_of(profile))
    assert what.kind == KINDS[seed % len(KINDS)]
    assert what.room.clearance_m(0.0, 0.0, 0.0) > 0.0
    assert len(what.points) in (2, 4)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("stick", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_no_chair_is_slower_to_stop_than_the_settings_claim(
    profile: str, kind: str, stick: tuple[float, float]
) -> None:
    settings = settings_of(profile)
    at = PROFILES.index(profile)

    def row(name: str) -> float:
        return float(getattr(settings, profile_row(at, name)))

    chair = AttackedChair(profile, kind, settings, even_left=True)
    for _ in range(800):
        chair.step(0.01, stick)
    speed, rate = abs(chair.speed_m_s), abs(chair.yaw_rate_deg_s)
    start = chair.x_m, chair.y_m, chair.heading_deg
    steps = 0
    while chair.speed_m_s or chair.yaw_rate_deg_s:
        chair.step(0.01, (0.0, 0.0))
        steps += 1
        assert steps < 600
    time_s = (row("dead_time_ms") + row("lag_ms")) / 1000.0
    if stick[0]:
        way = math.hypot(chair.x_m - start[0], chair.y_m - start[1])
        most = speed * time_s + speed**2 / (2.0 * row("brake_mm_s2") / 1000.0)
    else:
        way = abs(chair.heading_deg - start[2])
        most = rate * time_s + rate**2 / (2.0 * row("brake_dps2"))
    assert 0.0 < way <= 1.02 * most + 0.01 * max(speed, rate)
    if kind == "exact":
        assert way > 0.9 * most


def test_what_the_lidar_in_front_looks_at() -> None:
    chair = AttackedChair("3.1", "exact", settings_of("3.1"), even_left=True)
    ahead, beside_wheel = (1.0, 0.5), (-0.3, HALF_WIDTH_M + 0.02)
    assert in_view(FRONT, chair, (ahead,))
    assert not in_view(FRONT, chair, (beside_wheel,))
    assert in_view(FRONT, chair, (beside_wheel, ahead))
    assert in_view(CORNERS, chair, (beside_wheel,))
    chair.place(0.0, 0.0, 180.0)
    assert not in_view(FRONT, chair, (ahead,))
    assert in_view(FRONT, chair, (beside_wheel,))


def test_every_other_twenty_arcs_are_attacks() -> None:
    assert arc_trial(0).attack == ""
    assert arc_trial(21).attack == KINDS[0]
