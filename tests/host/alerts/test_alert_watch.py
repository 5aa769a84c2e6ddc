"""When the host calls somebody: help, a stuck chair, faults and lost parts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.alerts.reasons import HELP_WANTED, OVERRULED, PART, REASONS, STANDS
from gazechair.alerts.watch import GAVE_UP_S, MOVED_S, Situation, Watch

QUIET = Situation()
STUCK_S = 60.0


class Scene:
    """A watch that looks five times a second; each change is noted with its second."""

    def __init__(self, help_wanted: bool = False, stuck_s: float = STUCK_S) -> None:
        self.watch = Watch(stuck_s, help_wanted)
        self.now_s = 0.0
        self.open: set[str] = {HELP_WANTED} if help_wanted else set()
        self.seen: list[tuple[float, str, bool]] = []
        self.details: list[str] = []

    def see(self, situation: Situation, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s - 1e-6:
            for change in self.watch.look(situation, self.open, self.now_s):
                self.seen.append((round(self.now_s, 1), change.key, change.begins))
                self.details.append(change.detail)
                (self.open.add if change.begins else self.open.discard)(change.key)
            self.now_s = round(self.now_s + 0.2, 1)


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_help_is_wanted_at_once_until_somebody_has_come(scene: Scene) -> None:
    scene.see(QUIET, 1)
    scene.see(replace(QUIET, call=True), 5)
    scene.see(replace(QUIET, coming=True), 5)
    scene.see(QUIET, 5)
    assert scene.seen == [(1.0, HELP_WANTED, True), (11.0, HELP_WANTED, False)]


def test_help_of_before_a_restart_is_not_asked_twice() -> None:
    scene = Scene(help_wanted=True)
    scene.see(replace(QUIET, call=True), 1)
    assert scene.seen == []
    scene.see(QUIET, 1)
    assert scene.seen == [(1.0, HELP_WANTED, False)]


@pytest.mark.parametrize(
    ("key", "after_s"),
    [("tilt", 5.0), ("wiper", 10.0), ("board_lost", 60.0), ("lidar_lost", 60.0)],
)
def test_what_lasts_is_an_alert_and_what_passes_is_none(
    scene: Scene, key: str, after_s: float
) -> None:
    trouble = replace(QUIET, problems={key, "obstacle_left", "lidar_starting"})
    scene.see(trouble, after_s - 1)
    scene.see(QUIET, after_s)
    assert scene.seen == []
    scene.see(trouble, 200)
    scene.see(QUIET, 1)
    begins_s, ends_s = 3 * after_s - 1, 2 * after_s + 199
    assert scene.seen == [(begins_s, key, True), (ends_s, key, False)]
    assert REASONS[key].lasts_s == after_s


def flaps(scene: Scene, key: str, fails_s: float, works_s: float) -> list[str]:
    """A part (`key` is empty) or a problem that comes and goes for half an hour: its alerts."""
    failing = replace(QUIET, problems={key}) if key else replace(QUIET, lost={"map": "gone"})
    while scene.now_s < 1800.0:
        scene.see(failing, fails_s)
        scene.see(QUIET, works_s)
    return [key for _, key, begins in scene.seen if begins]


@pytest.mark.parametrize("key", ["lidar_lost", ""])
@pytest.mark.parametrize(("fails_s", "works_s"), [(55, 1), (10, 0.4), (10, 1), (5, 1), (30, 20)])
def test_what_fails_most_of_the_time_is_an_alert(
    scene: Scene, key: str, fails_s: float, works_s: float
) -> None:
    assert set(flaps(scene, key, fails_s, works_s)) == {key or PART}


@pytest.mark.parametrize("key", ["lidar_lost", ""])
@pytest.mark.parametrize(("fails_s", "works_s"), [(1, 5), (5, 6), (50, 60)])
def test_what_works_most_of_the_time_is_none(
    scene: Scene, key: str, fails_s: float, works_s: float
) -> None:
    assert flaps(scene, key, fails_s, works_s) == []


def test_a_pause_between_looks_does_not_count_as_working(scene: Scene) -> None:
    lost = replace(QUIET, problems={"lidar_lost"})
    scene.see(lost, 50)
    scene.now_s += 600.0  # the host was stopped
    scene.see(QUIET, 0.2)
    scene.see(lost, 15)
    assert [key for _, key, _ in scene.seen] == ["lidar_lost"]


def test_other_parts_are_named(scene: Scene) -> None:
    scene.see(replace(QUIET, lost={"log": "disk is full", "input gamepad": "gone"}), 400)
    assert scene.seen == [(300.0, PART, True)]
    assert scene.details == ["input gamepad: gone; log: disk is full"]


def test_each_part_is_lost_for_five_minutes_of_its_own(scene: Scene) -> None:
    scene.see(replace(QUIET, lost={"map": "gone"}), 150)
    scene.see(replace(QUIET, lost={"map": "gone", "odometry": "gone"}), 50)
    scene.see(replace(QUIET, lost={"odometry": "gone"}), 300)
    assert scene.seen == [(450.0, PART, True)]
    assert scene.details == ["odometry: gone"]


def test_a_lost_camera_is_not_told_with_the_parts_that_are_lost_too(scene: Scene) -> None:
    scene.see(replace(QUIET, problems={"camera_lost"}, lost={"log": "disk is full"}), 400)
    assert dict(zip((key for _, key, _ in scene.seen), scene.details, strict=True)) == {
        "camera_lost": "",
        PART: "log: disk is full",
    }


def tries(scene: Scene, times: int, every_s: float, first: int = 1) -> None:
    """Press after press, each overruled at once."""
    for press in range(first, first + times):
        scene.see(replace(QUIET, press=press, wants=True, overruled=True), 0.4)
        scene.see(replace(QUIET, press=press, overruled=True), every_s - 0.4)


def test_a_driver_who_presses_in_vain_for_long_is_stuck(scene: Scene) -> None:
    tries(scene, 6, 10.0)
    assert scene.seen == []
    tries(scene, 1, 1.0, 7)
    assert scene.seen == [(60.0, OVERRULED, True)]
    scene.see(replace(QUIET, press=8, wants=True, moving=True), MOVED_S + 0.4)
    assert scene.seen[1:] == [(63.0, OVERRULED, False)]


def test_a_chair_that_moves_in_between_or_a_driver_who_waits_is_not_stuck(scene: Scene) -> None:
    for press in range(1, 60, 10):
        tries(scene, 3, 10.0, press)
        scene.see(replace(QUIET, press=press + 5, wants=True, moving=True), MOVED_S + 0.4)
    tries(scene, 1, 10.0, 100)
    scene.see(replace(QUIET, press=100, overruled=True), GAVE_UP_S + 60.0)
    tries(scene, 5, 10.0, 101)
    assert scene.seen == []


def test_one_attempt_is_never_stuck_however_short_the_time() -> None:
    scene = Scene(stuck_s=10.0)
    tries(scene, 1, GAVE_UP_S + 60.0)
    assert scene.seen == []
    tries(scene, 2, 11.0, 2)
    assert [(key, begins) for _, key, begins in scene.seen] == [(OVERRULED, True)]


def test_what_odometry_measures_counts_whatever_the_board_puts_out(scene: Scene) -> None:
    held = replace(QUIET, wants=True, moving=True, problems={STANDS})
    scene.see(replace(QUIET, moving=True, problems={"motion_uncommanded"}), 1)
    assert scene.seen == [(0.0, "motion_uncommanded", True)]
    scene.seen.clear()
    for press in range(20):  # each try lasts 4 s: no alert alone, but together the chair is stuck
        scene.see(replace(held, press=press), 4)
        scene.see(replace(QUIET, press=press), 1)
    assert [key for _, key, _ in scene.seen] == [OVERRULED]
    scene.seen.clear()
    scene.see(held, 6)
    assert [key for _, key, _ in scene.seen] == [STANDS]
