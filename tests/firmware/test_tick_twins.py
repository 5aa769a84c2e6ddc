"""What the tick runs in machine words decides as its plain twin does, in random lives."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest

import plain_ages
import plain_core
from gazeboard.core import ages, limits
from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Way
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.shared import Inputs
from gazeboard.core.speed import SpeedBound
from gazeboard.core.stopping import Stopping
from gazeboard.io.settings import Settings
from gazelink import codes

_TICKS = 6_000
_COUNTS = [name for name in Inputs.FIELDS if name.endswith("_count")]
_AGES = ("host", "service", "clearance", "heading", "idle", "closed", "open", "off", "steady")


def _changed(roll: random.Random, i: Any) -> None:
    """Some of the inputs are others now."""
    for name in _COUNTS:
        if roll.random() < i.pace[name]:
            setattr(i, name, (getattr(i, name) + roll.choice((1, 1, 1, 2, 0xFFFF))) & 0xFFFF)
    if roll.random() < 0.01:
        i.pace = {name: roll.choice((0, 0, 0.01, 0.3, 1)) for name in _COUNTS}
    i.clearance_age_ms = roll.choice((0, 10, 100, 247, 248, 297, 298, 65535))
    i.ttl_ms = roll.choice((0, 1, 2, 3, 100, 150, 300, 400))
    i.mode = roll.randrange(4)
    i.supervision_age_ms = roll.choice((0, 1, 30, 2997, 2998, 3000, 60000))
    if roll.random() < 0.05:
        i.verb = roll.randrange(7)
        i.clearance_source = roll.choice((codes.REAL, codes.SIMULATED, codes.REPLAYED))
        i.heading_faults = roll.choice((0, 0, roll.randrange(1 << 24)))
        i.service_faults = roll.choice((0, 0, 1 << codes.TILT_UNKNOWN, 1 << codes.STORAGE))
        i.tilted = roll.choice((False, True))
        i.calibrated = roll.choice((False, True))


@pytest.mark.parametrize("seed", range(12))
def test_ages_and_faults(seed: int) -> None:
    """Every age, every order, every fault bit; the state and what is written follow at random."""
    roll = random.Random(seed)
    standing = roll.choice((0, 1 << codes.NO_HARD_TIMER))
    simulated, fitted = roll.choice((False, True)), roll.choice((False, True))
    words = ages.Ages()
    w = words.words
    w[ages.STANDING], w[ages.SIMULATED], w[ages.RELAY_FITTED] = standing, simulated, fitted
    plain = plain_ages.PlainAges(standing, simulated, fitted)
    w[ages.SUPERVISION_MOST] = plain.supervision_most = roll.choice((0, 498, 2998, 9998))
    i: Any = Inputs()
    i.pace = dict.fromkeys(_COUNTS, 0.3)
    old = 0
    lasting = [False] * 4
    for _ in range(_TICKS):
        _changed(roll, i)
        if roll.random() < 0.02:
            lasting = [roll.random() < 0.5 for _ in lasting]
        relay, button, late, on = lasting
        late = late and roll.random() < 0.01
        missed_ms = roll.choice((0,) * 50 + (1, 20, 1000, 1 << 20))
        news = words.count(i, relay, button, late, on, missed_ms)
        assert news == plain.count(i, relay, button, late, on, missed_ms)
        state = roll.choice((codes.DISARMED, codes.ARMING, codes.ARMED))
        w[ages.ARMING] = plain.arming = roll.choice((0, 149, 150))
        emergency, reset = roll.random() < 0.01, roll.random() < 0.1
        faults = words.faults(i, old, state, emergency, reset)
        assert faults == plain.faults(i, old, state, emergency, reset)
        old = faults
        for name in (*_AGES, "button", "ttl", "contact", "supervised", "presses"):
            assert w[getattr(ages, name.upper())] == getattr(plain, name), name
        if news & ages.ARM:
            assert w[ages.ARMS] == plain.arms


def _stoppings() -> list[Stopping]:
    settings = Settings()
    return [Stopping(settings, at, trusted) for at in range(4) for trusted in (False, True)]


def test_speed_bounds() -> None:
    """Whatever is put out, and whichever chair is believed in meanwhile."""
    roll = random.Random(1)
    stoppings = _stoppings()
    for _ in range(40):
        words, plain = SpeedBound(8), plain_core.PlainSpeedBound(8)
        permille = 0
        for _ in range(500):
            if roll.random() < 0.1:
                permille = roll.choice((0, 0, 1, 30, roll.randrange(1001), 1000))
            stopping = roll.choice(stoppings)
            assert words.update(stopping, permille) == plain.update(stopping, permille)


def test_levels_of_a_direction() -> None:
    """At every distance, also just beside those at which a level begins."""
    roll = random.Random(2)
    stoppings = _stoppings()
    for stopping in stoppings:
        words, plain = Way(), plain_core.PlainWay()
        edges = [*stopping.begin, 0, 65535]
        distance, permille = 0, 0
        for _ in range(5_000):
            if roll.random() < 0.03:
                distance = max(0, roll.choice(edges) + roll.randrange(-70, 70))
                permille = roll.choice((0, 100, 500, 1000))
            elif roll.random() < 0.1:
                distance = max(0, distance + roll.randrange(-3, 4))
            measured = roll.choice((0, -5, 100, 1600)) if roll.random() < 0.01 else 0
            age_ms = roll.choice((0, 2, 100, limits.AGE_MAX_MS))
            age_ms = age_ms if roll.random() < 0.02 else 10
            ceiling = 16 if roll.random() < 0.99 else roll.choice((-1, 0))
            for way in (words, plain):
                way.feel(stopping, permille, measured)
                way.judge(stopping, distance, age_ms, ceiling)
            found = (words.level, words.speed, words.rolls, words.stop, words._better_ms)
            assert found == (plain.level, plain.speed, plain.rolls, plain.stop, plain._better_ms)


@pytest.mark.parametrize("seed", range(6))
def test_obedience(seed: int) -> None:
    """Rates around what is allowed, outputs of either sign, faults, armed and not."""
    roll = random.Random(seed)
    settings = Settings()
    words, plain = Obedience(settings), plain_core.PlainObedience(settings)
    i = Inputs()
    out, armed, tripped = (0, 0), True, 0
    for ms in range(60_000):
        if ms % 10 == 0:
            i.heading_count = (i.heading_count + 1) & 0xFFFF
        if roll.random() < 0.002:
            out = (roll.choice((0, 0, 300)), roll.choice((0, 0, -1, 7, -333, 999, -1000)))
        if roll.random() < 0.001:
            near = roll.choice((128, 320, 128 + words._full_q4, 320 + words._full_q4))
            i.rate_q4 = roll.choice((1, -1)) * (near + roll.randrange(-1, 2))
        if roll.random() < 0.0005:
            armed = roll.random() < 0.8
            i.heading_faults = roll.choice((0, 0, 0, 1 << codes.HEADING_FROZEN))
        found = words.step(i, *out, armed)
        assert found is plain.step(i, *out, armed)
        tripped += found
    assert tripped


def test_both_axes_at_once() -> None:
    """What limits one axis takes the same share from the other; none points the other way."""
    roll = random.Random(3)
    settings = Settings()
    turn_controller = SimpleNamespace(follow=None, update=None, hold=None)
    motion = Motion(settings, turn_controller)

    def most() -> int:
        return roll.choice((0, 1, roll.randrange(1001), 1000))

    for _ in range(20_000):
        settings.linear_permille, settings.turn_permille = most(), most()
        asked = [roll.choice((1, -1)) * max(1, most()) for _ in range(2)]
        cap, caps = most(), [most() for _ in range(4)]
        arcs = roll.choice((None, SimpleNamespace(linear_cap=most(), turn_cap=most())))
        motion._drive_both(cap, *asked, caps, arcs)
        found = (motion.linear_permille, motion.turn_permille)
        assert found == plain_core.plain_drive_both(settings, cap, *asked, caps, arcs)


def test_trust_in_the_profile() -> None:
    """Model and gyro agree, contradict each other, or stand."""
    assert sum(map(_trusted, range(8)))


def _trusted(seed: int) -> int:
    """One life; in how many ticks the profile was trusted."""
    roll = random.Random(seed)
    model = SimpleNamespace(dead_ms=120, rate=0, is_steady=True)
    model.seen_rate = lambda: model.rate
    model.steady = lambda: model.is_steady
    words, plain = ProfileCheck(model), plain_core.PlainProfileCheck(model)
    i = Inputs()
    out, trusted = (0, 0), 0
    for ms in range(60_000):
        if ms % 10 == 0:
            i.heading_count = (i.heading_count + 1) & 0xFFFF
        if roll.random() < 0.001:
            turn = roll.choice((0, 299, 300, 499, 500, 1000))
            out = (roll.choice((0, 149, 150)), roll.choice((1, -1)) * turn)
            model.rate = roll.choice((0, 6144, 6145, 20000, -20000, -40000))
            model.is_steady = roll.random() < 0.8
        if roll.random() < 0.001:
            seen = roll.choice((0, model.rate, model.rate * 5 // 4, model.rate * 3 // 2 + 8192))
            i.rate_q4 = (seen >> 6) + roll.randrange(-1, 2)
            i.heading_faults = roll.choice((0, 0, 0, 1 << codes.HEADING_FROZEN))
        words.step(i, *out)
        plain.step(i, *out)
        assert (words.agreed, words.sluggish) == (plain.agreed, plain.sluggish)
        trusted += words.agreed
    return trusted
