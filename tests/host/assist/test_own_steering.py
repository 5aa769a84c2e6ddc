"""The more the driver corrects assist, the less it helps, also in the choice of ways."""

import itertools
import math
import random

import numpy as np
import pytest

from gazechair.assist.own_steering import OwnSteering
from gazechair.assist.ways import Ways
from gazechair.base.footprint import Footprint, Margins


def corrected(deg, after_s=1.0):
    """Assist steered, then the driver held a turn of so many degrees: (own, its end)."""
    own = OwnSteering()
    own.steered(10.0)
    now_s, turned = 10.0 + after_s, 0.0
    own.turns(turned, now_s)
    while turned < deg:
        turned, now_s = min(deg, turned + 1.0), now_s + 0.05
        own.turns(-turned, now_s)
    return own, now_s


def test_without_a_correction_it_is_whole():
    own = OwnSteering()
    assert own.help(0.0) == 1.0
    own.turns(0.0, 1.0)
    own.turns(50.0, 1.1)  # the driver chooses a direction: assist had not steered
    assert own.help(1.2) == 1.0
    own, now_s = corrected(40.0, after_s=5.0)
    assert own.help(now_s) == 1.0


def test_the_more_he_corrects_the_less_it_helps():
    shares = []
    for deg in range(0, 181, 5):
        own, now_s = corrected(float(deg))
        shares.append(own.help(now_s))
    assert all(later < sooner for sooner, later in itertools.pairwise(shares))
    assert shares[4] == pytest.approx(0.5, abs=0.03)
    assert 0.0 < shares[-1] < 0.15


def test_it_comes_back_with_time_and_never_beyond_the_whole():
    own, now_s = corrected(60.0)
    shares = [own.help(now_s + after_s) for after_s in range(0, 100, 5)]
    assert all(sooner < later <= 1.0 for sooner, later in itertools.pairwise(shares))
    assert shares[-1] > 0.99


def test_less_help_leads_less_far_from_where_he_points_whatever_is_around():
    chance = random.Random(3)
    ways = Ways(Footprint(margins=Margins()))
    chosen = 0
    for _ in range(60):
        things = []
        for _ in range(chance.randint(1, 5)):
            x, y, long_m = chance.uniform(1.0, 3.0), chance.uniform(-1.5, 1.5), chance.random()
            angle = chance.uniform(0.0, math.pi)
            at = np.linspace(-long_m, long_m, 60)[:, None]
            things.append(np.array((x, y)) + at * (math.cos(angle), math.sin(angle)))
        points = np.concatenate(things)
        pointed_rad = math.radians(chance.uniform(-10.0, 10.0))
        for share in (1.0, 0.6, 0.3, 0.0):
            way = ways.choose(points, pointed_rad, None, (360.0, 360.0), False, share)
            if way is not None:
                chosen += 1
                most_rad = math.radians(35.0 * share + 2.1)
                assert (
                    max(abs(way.first_rad - pointed_rad), abs(way.then_rad - pointed_rad))
                    <= most_rad
                )
    assert chosen > 30
