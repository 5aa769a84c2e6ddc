"""The doctor warns of a chair that is larger than the board assumes."""

from __future__ import annotations

import pytest

from gazeboard.core import limits
from gazechair.config.settings import Config, FootprintConfig
from gazechair.service import doctor


def test_the_doctor_goes_by_the_boards_own_limit() -> None:
    assert limits.OUTERMOST_MM / 1000.0 == doctor._OUTERMOST_M


@pytest.mark.parametrize(
    ("front_m", "level"), [(0.65, doctor.OK), (0.70, doctor.WARN), (1.5, doctor.WARN)]
)
def test_a_corner_beyond_the_boards_limit_is_warned_of(front_m: float, level: str) -> None:
    corners = ((front_m, 0.375), (-0.45, 0.375), (-0.45, -0.375), (front_m, -0.375))
    (finding,) = doctor._footprint(Config(footprint=FootprintConfig(corners_m=corners)))
    assert (finding.what, finding.level) == ("footprint", level)
    assert bool(finding.do) is (level == doctor.WARN)


def test_the_chair_that_ships_is_not_warned_of() -> None:
    (finding,) = doctor._footprint(Config())
    assert finding.level == doctor.OK
