"""P5 and P6 end to end: obstacles from the lidar's bytes to the wheels, and data that grows old."""

from __future__ import annotations

from typing import Any

import pytest

from e2e import states
from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, measured

pytestmark = pytest.mark.costly

# Before, to the left, to the right of the lidar, near enough for the sector and for nothing else.
PLACES = {
    "forward": {"ahead_m": 0.75, "left_m": 0.0, "size_m": 0.2},
    "left": {"ahead_m": 0.6, "left_m": 0.45, "size_m": 0.1},
    "right": {"ahead_m": 0.6, "left_m": -0.45, "size_m": 0.1},
}


NEAR = (300, 300, 20 * 16, 20 * 16)  # mm, mm, 1/16 degree


def way_of(inputs: Any, direction: int) -> int:
    """How far the board has been told that it may go."""
    names = ("forward_mm", "backward_mm", "left_q4", "right_q4")
    return int(getattr(inputs, f"clearance_{names[direction]}"))


@pytest.mark.parametrize("verb", PLACES)
@pytest.mark.parametrize("mode", ["continuous", "step"])
def test_p5_someone_steps_in_the_way(verb: str, mode: str) -> None:
    direction = codes.DIRECTIONS.index(verb)
    chair = states.driving(verb, mode, 250)
    begun_ms = chair.now_ms
    chair.world.faults.inject("obstacle", **PLACES[verb])
    back = chair.board.app.inbox
    chair.until(lambda: way_of(back.front, direction) < NEAR[direction], 300)
    decoded_ms = chair.now_ms
    chair.until(chair.neutral, 10)
    cause = "obstacle on the path, from the decoded frame"
    measured(END_TO_END, "P5", cause, chair.now_ms - decoded_ms, 2)
    cause = "obstacle on the path, from its first moment: lidar, host and line included"
    measured(END_TO_END, "P5", cause, chair.now_ms - begun_ms, None)
    chair.run(60)
    assert chair.override() == f"obstacle_{verb}"
    assert chair.page.shown["override"] == f"obstacle_{verb}"
    assert chair.page.shown["decisions"][verb] == "blocked"
    chair.stays_still(300)
    chair.world.faults.clear("obstacle")
    chair.needs_a_new_press(verb)


def test_p5_an_obstacle_beside_the_path_stops_nothing(driving: Lockstep) -> None:
    driving.world.faults.inject("obstacle", **PLACES["left"])
    driving.run(50)
    for _ in range(200):
        driving.one_ms()
        assert not driving.neutral(), driving.why()


def test_p5_driving_at_a_wall_ends_before_it() -> None:
    chair = Lockstep("wall")
    chair.drive()
    chair.until(chair.neutral, 20000)
    assert chair.override() == "obstacle_forward"
    chair.comes_to_rest()
    assert chair.world.collisions == 0
    assert chair.world.truth()["clearance_m"] > 0.1


def test_p5_a_covered_lidar_blocks(driving: Lockstep) -> None:
    lidar = driving.world.lidar
    lidar.beams.covered_deg = (-180.0, 179.9)  # no return from anywhere
    driving.until(driving.neutral, 300)
    assert driving.override() == "obstacle_forward"
    driving.stays_still(300)
    lidar.beams.covered_deg = None
    driving.needs_a_new_press()


@pytest.mark.parametrize(
    ("arc_deg", "verb"),
    [((-30.0, 20.0), "forward"), ((-120.0, 0.0), "forward"), ((85.0, 121.0), "left")],
)
def test_p5_a_half_covered_lidar_blocks_what_it_no_longer_sees(
    arc_deg: tuple[float, float], verb: str
) -> None:
    chair = states.driving(verb)
    chair.world.lidar.beams.covered_deg = arc_deg
    chair.until(chair.neutral, 300)
    assert chair.override() == f"obstacle_{verb}"
    chair.run(60)
    assert chair.page.shown["view"][verb] == "blind"
    chair.stays_still(300)
    chair.world.lidar.beams.covered_deg = None
    chair.needs_a_new_press(verb)
    chair.run(60)
    assert chair.page.shown["view"][verb] != "blind"


def test_p5_what_a_covered_side_does_not_look_at_stays_free(driving: Lockstep) -> None:
    driving.world.lidar.beams.covered_deg = (85.0, 121.0)
    for _ in range(600):
        driving.one_ms()
        assert not driving.neutral(), driving.why()
    assert driving.page.shown["view"]["left"] == "blind"


def test_p5_what_is_never_seen_is_unseen_and_only_crept_into(chair: Lockstep) -> None:
    chair.drive("left", ms=1500)
    assert chair.page.shown["view"]["left"] == "unseen"
    assert chair.page.shown["decisions"]["left"] == "slow"
    assert 0 < chair.world.chair.yaw_rate_deg_s < 15.0
    assert chair.page.shown["view"]["forward"] == "seen"


LIDAR_FAULTS = ("lidar_stall", "lidar_mirror_blocked", "lidar_protection_stop")


def note_age(chair: Lockstep, cause: str) -> None:
    """From the acquisition of the newest measurement that came until both wipers are neutral."""
    assert chair.host is not None
    clearance = chair.host.control._clearance
    assert clearance is not None
    scan_s = clearance.acquired_s
    chair.until(chair.neutral, 400)
    measured(END_TO_END, "P6", cause, chair.now_ms - round(scan_s * 1000), limits.CLEARANCE_OLD_MS)
    assert chair.override() == "obstacle_data_old"
    chair.run(120)
    assert set(chair.page.shown["decisions"].values()) == {"unknown"}


@pytest.mark.parametrize("fault", LIDAR_FAULTS)
@pytest.mark.parametrize("verb", ["forward", "left"])
def test_p6_lidar_silent(fault: str, verb: str) -> None:
    chair = states.driving(verb)
    chair.world.faults.inject(fault)
    chair.run(30)  # its last bytes arrive
    note_age(chair, f"lidar: {fault.removeprefix('lidar_').replace('_', ' ')}")
    chair.stays_still(1000)
    assert chair.armed()
    chair.world.faults.clear(fault)
    if fault == "lidar_protection_stop":
        chair.world.lidar.receive(b"\xa5\x20")  # as its child process, started anew, asks it to
    chair.needs_a_new_press(verb)


@pytest.mark.parametrize("verb", ["forward", "left"])
def test_p6_a_lidar_that_repeats_itself(verb: str) -> None:
    chair = states.driving(verb)
    begun_ms = chair.now_ms
    chair.world.faults.inject("lidar_frozen")
    chair.until(chair.neutral, 400)
    took_ms = chair.now_ms - begun_ms
    measured(END_TO_END, "P6", "lidar: repeats itself, from the first repetition", took_ms, 300)
    assert chair.override() == "obstacle_data_old"
    chair.stays_still(1000)
    chair.world.faults.clear("lidar_frozen")
    chair.needs_a_new_press(verb)


def test_p6_lidar_child_dead_while_its_host_lives(driving: Lockstep) -> None:
    assert driving.host is not None
    driving.host.lidar_child = False  # the last word is repeated every 50 ms, its age grows
    note_age(driving, "lidar's process dead, the host goes on sending")
    driving.stays_still(1000)
    driving.host.lidar_child = True
    driving.needs_a_new_press()


def test_p6_damaged_scans_never_make_the_way_free(driving: Lockstep) -> None:
    for corrupt, drop in ((0.002, 0.0), (0.0, 0.002), (0.02, 0.02)):
        driving.world.faults.inject("lidar_corrupt", share=corrupt)
        driving.world.faults.inject("lidar_drop", share=drop)
        driving.world.faults.inject("obstacle", **PLACES["forward"])
        driving.until(driving.neutral, 600)
        driving.page.press("forward")
        driving.stays_still(1000)
        driving.world.faults.clear("obstacle")
    driving.world.faults.clear("lidar_corrupt")
    driving.world.faults.clear("lidar_drop")
    driving.run(500)
    driving.needs_a_new_press()
