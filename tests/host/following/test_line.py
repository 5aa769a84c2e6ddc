"""Line follower: what a tap chooses, crossings, gaps, light, the end, and lost means stopped."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.following.line import LOST_S, LineFollower, State
from gazechair.following.line_trace import trace
from gazechair.following.line_view import NO_LINE, NOT_SEEN, PlanMaker, chosen
from gazechair.following.request import STOP
from gazechair.picture.floor import FloorCamera
from gazesim.floor_view import Eye, Floor, FloorView

pytestmark = pytest.mark.costly

EYE = Eye(field_deg=75.0, height_m=1.15, down_deg=30.0)
CAMERA = FloorCamera(
    160, 120, 80.0 / math.tan(math.radians(37.5)), 1.15, math.radians(30.0), x_m=0.3
)
STRAIGHT = np.array(((0.8, 0.0), (6.0, 0.0)))
POSE = np.zeros(3)


def _view(**changes: object) -> FloorView:
    return FloorView(EYE, Floor(**{"lines": [STRAIGHT], **changes}), 3)  # type: ignore[arg-type]


def _picture(view: FloorView, x_m: float = 0.0) -> FloatArray:
    return view.picture(x_m, 0.0, 0.0, 160)


def _pixel(x_m: float, y_m: float) -> tuple[float, float]:
    u, v = EYE.pixel(x_m, y_m)
    return 0.5 * u, 0.5 * v


def _following(view: FloorView) -> LineFollower:
    follower = LineFollower(CAMERA, 0.35, math.radians(45.0), 0.3)
    assert follower.choose(_picture(view), _pixel(1.8, 0.0), POSE, 0.0) == ""
    return follower


def test_the_independent_camera_agrees() -> None:
    points = np.array(((1.3, 0.3), (2.0, -0.4)))
    seen = np.array([_pixel(*point) for point in points])
    assert np.abs(CAMERA.pixels(points) - seen).max() < 1e-6


@pytest.mark.parametrize(
    "tape", [(0.05, 0.16, 0.5), (0.75, 0.6, 0.05), (0.03, 0.03, 0.03), (0.9, 0.9, 0.88)]
)
def test_a_tapped_tape_is_found_and_traced_in_any_light(tape: tuple[float, float, float]) -> None:
    for light in ((1.0, 1.0, 1.0), (0.5, 0.35, 0.25)):
        follower = LineFollower(CAMERA, 0.35, 0.8, 0.3)
        picture = _picture(_view(tape=tape, light=light))
        assert follower.choose(picture, _pixel(1.8, 0.02), POSE, 0.0) == ""
        line = follower.line_m
        assert np.abs(line[:, 1]).max() < 0.03
        assert line[-1, 0] > 2.3


def test_where_there_is_no_line_none_is_chosen() -> None:
    follower = LineFollower(CAMERA, 0.35, 0.8, 0.3)
    picture = _picture(_view())
    assert follower.choose(picture, _pixel(1.8, 0.5), POSE, 0.0) == NO_LINE
    assert follower.choose(picture, (80.0, 1.0), POSE, 0.0) == NOT_SEEN
    assert follower.state is State.OFF
    edge = _view(lines=[], rugs=[(2.0, 0.6, 1.0, 0.6, (0.06, 0.18, 0.55))])
    assert follower.choose(_picture(edge), _pixel(1.8, 0.0), POSE, 0.0) == NO_LINE


def _end_of_trace(view: FloorView) -> tuple[FloatArray, bool]:
    plans = PlanMaker(CAMERA)
    found = chosen(plans(_picture(_view())), np.array((1.8, 0.0)))
    assert not isinstance(found, str)
    traced = trace(plans(_picture(view)), found[0], np.array((1.2, 0.0)), 0.0)
    return traced.points_m, traced.ended


@pytest.mark.parametrize(
    "changes",
    [
        {"lines": [STRAIGHT, np.array(((1.7, -0.8), (1.9, 0.8)))]},
        {"gaps": [(1.6, 0.0, 0.05), (2.1, 0.0, 0.05)]},
        {"shadows": [(1.6, 0.1, 0.25, 0.35)]},
        {"glare": (1.7, 0.0, 0.12)},
        {"rugs": [(1.8, 0.45, 0.4, 0.3, (0.16, 0.22, 0.47))]},
    ],
    ids=["crossing", "gaps", "shadow", "glare", "rug of similar colour"],
)
def test_goes_straight_on_over(changes: dict[str, object]) -> None:
    points, _ = _end_of_trace(_view(**changes))
    assert np.abs(points[:, 1]).max() < 0.05
    assert points[-1, 0] > 2.3


def test_the_end_is_seen_and_a_corner_is_not_one() -> None:
    points, ended = _end_of_trace(_view(lines=[np.array(((0.8, 0.0), (1.9, 0.0)))]))
    assert ended
    assert abs(points[-1, 0] - 1.9) < 0.06
    corner = np.array(((0.8, 0.0), (1.8, 0.0), (1.8, 0.7)))
    points, _ = _end_of_trace(_view(lines=[corner]))
    assert points[-1, 1] > 0.5


def test_a_line_that_is_gone_or_no_picture_stops_in_time() -> None:
    bare = _picture(_view(lines=[]))
    for goes_on in (True, False):
        follower = _following(_view())
        requests = {}
        for tick in range(1, 25):
            now = 0.05 * tick
            if goes_on:
                follower.look(bare, POSE, now)
            requests[tick] = follower.step(POSE, 0.2, 0.0, now, 0.05)
        assert requests[4].linear_m_s > 0.0
        # A request holds until the next one: the last ends 0.3 s after the line was seen.
        assert all(
            one == STOP for tick, one in requests.items() if 0.05 * (tick + 1) > LOST_S + 1e-6
        )
        assert follower.state is State.LOST
        follower.look(_picture(_view()), POSE, 1.3)
        assert follower.step(POSE, 0.0, 0.0, 1.31, 0.05) == STOP  # until it is chosen again


def test_goes_on_after_a_moment_without_a_picture() -> None:
    follower = _following(_view())
    assert follower.step(POSE, 0.0, 0.0, 0.5, 0.05) == STOP
    assert follower.state is State.FOLLOWS
    follower.look(_picture(_view()), POSE, 0.5)
    assert follower.step(POSE, 0.0, 0.0, 0.55, 0.05).linear_m_s > 0.0


_BEND = np.array([(0.8 + 0.05 * k, 0.004 * k * k) for k in range(40)])


@pytest.mark.parametrize("how", ["frozen", "black", "white", "upside down", "1x1", "wider", "grey"])
def test_a_camera_that_shows_something_else_stops_it(how: str) -> None:
    view = _view(lines=[_BEND])
    follower = LineFollower(CAMERA, 0.35, math.radians(45.0), 0.3)
    assert follower.choose(_picture(view), _pixel(1.3, 0.4), POSE, 0.0) == ""
    good = view.picture(0.0, 0.0, 0.0, 160)
    follower.look(good, POSE, 0.0)
    shown = {
        "frozen": good,
        "black": np.zeros_like(good),
        "white": np.full_like(good, 255),
        "upside down": good[::-1, ::-1],
        "1x1": good[:1, :1],
        "wider": np.concatenate((good, good), axis=1),
        "grey": good[..., 0],
    }[how]
    begun = None
    for tick in range(1, 40):
        now, pose = 0.05 * tick, np.array((0.015 * tick, 0.0, 0.0))
        follower.look(shown, pose, now)
        request = follower.step(pose, 0.3, 0.0, now, 0.05)
        moved = how != "frozen" or pose[0] > 0.06
        begun = now if moved and begun is None else begun
        assert begun is None or now <= begun + LOST_S or request == STOP
    assert follower.state is State.LOST


@pytest.mark.parametrize("how", ["a clock runs", "noise"])
def test_a_picture_that_hangs_but_for_a_detail_stops_it(how: str) -> None:
    view = _view(lines=[_BEND])
    follower = LineFollower(CAMERA, 0.35, math.radians(45.0), 0.3)
    assert follower.choose(_picture(view), _pixel(1.3, 0.4), POSE, 0.0) == ""
    good = _picture(view)
    random = np.random.default_rng(5)
    for tick in range(1, 60):
        now, pose = 0.05 * tick, np.array((0.015 * tick, 0.0, 0.0))
        shown = good.copy()
        if how == "a clock runs":
            shown[:8, :20] = random.integers(0, 256)
        else:
            shown = np.clip(good + random.integers(-2, 3, good.shape), 0, 255).astype(np.uint8)
        follower.look(shown, pose, now)
        request = follower.step(pose, 0.3, 0.0, now, 0.05)
    assert request == STOP
    assert follower.state is State.LOST


def test_a_chair_that_stands_sees_the_same_again_and_starts() -> None:
    view = _view()
    follower = _following(view)
    same = _picture(view)
    for tick in range(1, 20):
        follower.look(same, POSE, 0.05 * tick)
        request = follower.step(POSE, 0.0, 0.0, 0.05 * tick, 0.05)
    assert request.linear_m_s > 0.2


def test_goes_straight_to_where_the_line_is_seen_first() -> None:
    view = _view()
    follower = _following(view)
    for tick in range(1, 60):
        pose = np.array((0.02 * tick, 0.005 * (-1) ** tick, 0.0))  # odometry's noise
        follower.look(_picture(view, pose[0]), pose, 0.05 * tick)
        request = follower.step(pose, 0.35, 0.0, 0.05 * tick, 0.05)
        assert abs(request.yaw_rad_s) < 0.1


def test_steers_to_the_line_and_stops_at_its_end() -> None:
    line = np.array(((0.8, 0.12), (2.6, 0.12)))
    view = _view(lines=[line])
    follower = LineFollower(CAMERA, 0.35, 0.8, 0.0)
    assert follower.choose(_picture(view), _pixel(1.8, 0.12), POSE, 0.0) == ""
    pose, now, speed = np.zeros(3), 0.0, 0.0
    for tick in range(600):
        now += 0.05
        if tick % 2 == 0:
            picture = view.picture(*pose[:2], math.degrees(pose[2]), 160)
            follower.look(picture, pose, now)
        request = follower.step(pose, speed, 0.0, now, 0.05)
        assert request.linear_m_s <= 0.35
        speed = request.linear_m_s
        pose = pose + 0.05 * np.array(
            (speed * math.cos(pose[2]), speed * math.sin(pose[2]), request.yaw_rad_s)
        )
        if follower.state is not State.FOLLOWS:
            break
    assert follower.state is State.ENDED
    assert abs(pose[0] + 0.65 - 2.6) < 0.08
    assert abs(pose[1] - 0.12) < 0.03


def test_another_size_of_picture_is_refused() -> None:
    with pytest.raises(ValueError, match="not"):
        PlanMaker(CAMERA)(np.zeros((90, 160, 3), dtype=np.uint8))


def test_a_slower_chair_asks_for_less_of_both_and_so_for_the_same_curve() -> None:
    curves = []
    for most_m_s in (0.35, 0.25, 0.1, 0.05):
        view = _view(lines=[_BEND])
        follower = LineFollower(CAMERA, most_m_s, math.radians(90.0), 0.0)
        assert follower.choose(_picture(view), _pixel(1.3, 0.4), POSE, 0.0) == ""
        for tick in range(1, 40):
            follower.look(_picture(view), POSE, 0.05 * tick)
            request = follower.step(POSE, 0.0, 0.0, 0.05 * tick, 0.05)
        assert request.linear_m_s == pytest.approx(most_m_s)
        curves.append(request.yaw_rad_s / request.linear_m_s)
    assert curves == pytest.approx([curves[0]] * 4, rel=1e-6)
    assert abs(curves[0]) > 0.05
