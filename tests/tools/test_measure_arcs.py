"""The arcs of the obstacles benchmark: attacks hit without the rule, and their chairs' physics."""

from __future__ import annotations

import math

import pytest

from gazelink.settings_table import PROFILES, profile_row
from gazemeasure.obstacles_arcs import ArcRun, ArcTask, Hold, arc_trial, attack_trial
from gazemeasure.obstacles_attack import KINDS, AttackedChair, attack, attacked_chair, in_view
from gazemeasure.obstacles_eyes import CORNERS, FRONT
from gazemeasure.turn_board import settings_with
from gazesim.chair import HALF_WIDTH_M


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
