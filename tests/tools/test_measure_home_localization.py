"""The benchmark of finding oneself counts what it should."""

from __future__ import annotations

import math

import numpy as np

from gazechair.sensing.mapping.localization import Location
from gazechair.sensing.mapping.map_match import Evidence
from gazemeasure import home_localization
from gazemeasure.home_localization import Counted
from gazemeasure.report import Report
from gazesim import home_plans

POSE = np.array((3.0, -1.0, 2.0))


def claimed(x_m: float, heading_deg: float) -> Location:
    pose = POSE + np.array((x_m, 0.0, math.radians(heading_deg)))
    return Location(pose, Evidence(1.0, 0.0), 0.02, 0.01)


def test_right_is_within_10_cm_and_3_degrees_the_rest_is_confidently_wrong() -> None:
    counted = Counted()
    for found in (claimed(0.09, 2.9), claimed(0.11, 0.0), claimed(0.0, 3.1), None):
        counted.count("as mapped", found, POSE)
    assert counted.right == {"as mapped": 1}
    assert counted.wrong == {"as mapped": 2}
    assert counted.unknown == {"as mapped": 1}


def test_one_confidently_wrong_start_falls_short() -> None:
    done = Counted(after_s=[2.0], lost_after_s=[2.0], look_ms=[100.0])
    for kind in ("as mapped", "doors and furniture moved", "70 % hidden by a crowd"):
        done.count(kind, claimed(0.0, 0.0), POSE)
    report = Report("home")
    home_localization.measure(report, True, lambda *_: [done])
    assert report.ok
    done.count("70 % hidden by a crowd", claimed(1.0, 0.0), POSE)
    report = Report("home")
    home_localization.measure(report, True, lambda *_: [done])
    assert not report.ok


def test_people_hide_as_much_as_they_should() -> None:
    home = home_plans.home(2)
    home.people = ()
    chance = np.random.default_rng(1)
    pose = np.array((*home.places["corridor"], 0.0))
    seen = [home_localization.look(home, pose, chance, hidden=share) for share in (0.0, 0.7)]
    near = [(np.hypot(*(one.points_m - one.origins_m).T) < 1.5).mean() for one in seen]
    assert near[1] > near[0] + 0.1
