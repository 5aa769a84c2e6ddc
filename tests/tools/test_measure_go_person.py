"""Following a person, as measured: the judge counts a request until the next scan replaces it."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.following.follower import Followed
from gazechair.following.person import State
from gazechair.following.request import Request
from gazemeasure.go import person
from gazesim import home_plans
from gazesim.home_routes import Router

HERE = np.zeros(3)


def test_a_request_counts_until_the_next_scan() -> None:
    home = home_plans.home(0)
    home.people, home.script = (), ()
    run = person._Run(home, Router(home), 0, False, None)
    asks = Followed(State.FOLLOWS, Request(0.2, 0.0), None)
    for number in range(6):
        run._judge(asks, HERE, HERE, seen=number == 0)
        assert run._judged.late_s == pytest.approx(0.1 * (number + 1))
