"""The people of the scanning benchmark, without a page or a chair."""

from __future__ import annotations

from dataclasses import dataclass

from gazemeasure.scanning_person import Gazer, Switcher, Way


@dataclass
class Pose:
    x_m: float = -2.3
    y_m: float = 0.0
    heading_deg: float = 0.0
    speed_m_s: float = 0.0
    yaw_rate_deg_s: float = 0.0


def wanted(pose: Pose, moving: str | None = None, way: Way | None = None) -> str | None:
    way = way or Way(0.1, 2.5)
    way.see(pose)
    return way.wanted(moving, 1.0)


def test_the_way_leads_to_the_axis_and_along_it() -> None:
    assert wanted(Pose()) == "forward"
    assert wanted(Pose(y_m=-0.4)) == "left"
    assert wanted(Pose(y_m=0.4)) == "right"
    assert wanted(Pose(y_m=-0.4, heading_deg=20)) == "forward"
    assert wanted(Pose(heading_deg=5)) == "right"
    assert wanted(Pose(x_m=-0.8, y_m=0.1)) == "right"  # near to the door: to its centre
    assert wanted(Pose(x_m=-0.8, y_m=0.1, heading_deg=-4)) == "forward"
    way = Way(0.1, 2.5)
    near = Pose(x_m=-1.2, y_m=-0.05, heading_deg=20, speed_m_s=0.2)
    assert wanted(Pose(y_m=-0.4, heading_deg=20), None, way) == "forward"
    assert wanted(near, "forward", way) is None  # a second later it is on the axis
    assert wanted(Pose(x_m=-1.1, heading_deg=20), None, way) == "right"


def test_the_switch_is_pressed_after_the_light_and_held_as_long_as_planned() -> None:
    way, person = Way(0.1, 2.5), Switcher(1, True)
    way.see(Pose(heading_deg=-19))
    events, at = [], 0.0
    for n in range(200):
        at = n * 0.025
        person.sees(["left"] if at >= 1.0 else ["forward"])
        for kind, _ in person.tick(at, way, False):
            events.append((kind, at))
            if kind == "keydown":
                person.receives("left", 1, at, way)
    (down, pressed_s), (up, released_s) = events
    assert (down, up, person.presses) == ("keydown", "keyup", 1)
    assert 1.15 <= pressed_s <= 2.7
    assert 1.0 <= released_s - pressed_s <= 3.0  # 19 degrees at 9.5 a second


def test_a_gaze_that_nothing_answers_looks_away_and_again() -> None:
    way, person = Way(0.1, 2.5), Gazer(1, True)
    way.see(Pose(heading_deg=-19))
    looks = [person.tick(n * 0.025, way, False)[0][1] for n in range(400)]
    changes = [look for n, look in enumerate(looks) if n == 0 or looks[n - 1] != look]
    assert changes[:4] == [None, "left", None, "left"]


def test_who_stands_before_the_door_lets_go_turns_and_goes_on() -> None:
    way, person = Way(0.1, 2.5), Switcher(1, True)
    way.see(Pose(x_m=-0.9, y_m=0.03, heading_deg=-1))
    person.sees(["forward"])
    events = []
    for n in range(300):
        for kind, _ in person.tick(n * 0.025, way, False):
            events.append(kind)
            if kind == "keydown":
                person.receives("forward", 1, n * 0.025, way)
        if "keyup" in events:
            person.receives("stop", 0, n * 0.025, way)
            break
    assert events == ["keydown", "keyup"]
    assert way.wanted(None, 1.0) == "right"
    way.turns()
    assert way.wanted(None, 1.0) == "forward"
