"""Where what stands still is: to the centimetre, also where no beam goes any more."""

from __future__ import annotations

import numpy as np

from gazechair.following.background import Background

_ORIGIN = np.zeros(2)
_POST = np.array(((1.512, 0.303), (1.516, 0.297), (1.533, 0.291)))
_WALL = np.stack((np.full(60, 3.0), np.linspace(-1.5, 1.5, 60)), axis=1)
_ROUND_POST = (1.3, 0.1), (1.7, 0.5)


def _standing(background: Background) -> np.ndarray:
    return background.standing_m(*map(np.array, _ROUND_POST))


def _looks(background: Background, points: np.ndarray, times: int, origin: np.ndarray) -> None:
    for _ in range(times):
        background.stands(points, origin)
        background.learn(points, origin, ())


def test_what_stands_is_known_to_the_centimetre_also_out_of_view() -> None:
    background = Background()
    _looks(background, np.concatenate((_POST, _WALL)), 8, _ORIGIN)
    assert not len(_standing(background))  # not yet
    _looks(background, np.concatenate((_POST, _WALL)), 8, _ORIGIN)
    gaps = np.hypot(*(_standing(background)[:, None] - _POST).T)
    assert gaps.min(axis=0).max() < 0.01
    beyond = np.array((3.5, 0.6))  # nothing of it is in view from here, and the window moves on
    _looks(background, _WALL[40:] + np.array((3.0, 0.0)), 40, beyond)
    assert np.hypot(*(_standing(background)[:, None] - _POST).T).min(axis=0).max() < 0.01


def test_only_the_newest_returns_of_a_place_count() -> None:
    """A pose that drifts does not make things grow."""
    background = Background()
    for k in range(20):
        post = _POST + np.array((0.0024 * k, 0.0))
        _looks(background, np.concatenate((post, _WALL)), 2, _ORIGIN)
    gaps = np.hypot(*(_standing(background)[:, None] - post).T).min(axis=0)
    assert gaps.max() < 0.01


def test_what_beams_pass_through_is_gone_at_once() -> None:
    background = Background()
    _looks(background, np.concatenate((_POST, _WALL)), 40, _ORIGIN)
    assert len(_standing(background))
    bearings = np.linspace(-0.5, 0.5, 400)
    hall = 3.0 * np.stack((np.cos(bearings), np.sin(bearings)), axis=1)
    _looks(background, hall, 7, _ORIGIN)
    assert not len(_standing(background))
