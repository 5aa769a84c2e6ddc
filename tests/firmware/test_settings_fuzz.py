"""Any legal settings on any of the twin's chairs: nothing seen is hit, and creep is creep.

The board's own motion, obstacle rule and profile check against the twin, with a wall in the way of
one motion. What is believed about the chair is drawn at random from all that may be set; the chair
is one of the five. Half of the runs gain trust in the profile first.
"""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from gazeboard.core import limits
from gazeboard.core.motion import Motion
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazeboard.turning.turn import turn_controller
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from gazelink.settings_table import PROFILE_ROWS, PROFILES, TABLE, profile_row
from gazesim.chair import Chair

SEEDS = range(6), range(6, 24)
some_seeds = pytest.mark.parametrize(
    "seeds", [SEEDS[0], pytest.param(SEEDS[1], marks=pytest.mark.recorded)], ids=str
)
NEUTRAL = ("neutral_linear_count", "neutral_turn_count")  # by calibration only
PREFIX = profile_row(0, "")
VERBS = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT)
FIELDS = ("forward_mm", "backward_mm", "left_q4", "right_q4")
# A chair believed to be tame, and all that may be let out of it.
LOW = ("forward", "backward", "left", "right", "dead", "lag", "reaction", "stop")
HIGH = ("brake", "linear", "turn")
Q4_DEG_MM = limits.OUTERMOST_MM / 917  # of the outermost point, per 1/16 degree
AGE_MS = 70
LOOK_MS = 25
GRAIN_MM_S = 8  # a turn's veer and the table's rounding


class Fuzzed:
    """The board's decisions about one motion, the chair that makes it, and what it must not touch.

    Distances are in mm straight on and in 1/16 degree in turns, as on the wire.
    """

    def __init__(self, settings: Any, profile: str, seed: int) -> None:
        self.settings = settings
        self.obstacles: Any = Obstacles(settings)
        turn: Any = turn_controller(settings)
        self.motion: Any = Motion(settings, turn)
        self.check: Any = ProfileCheck(turn.model)
        self.i: Any = Inputs()
        self.i.cap_permille = 1000
        self.chair = Chair(profile, seed)
        self.chair.step(0.001, (0.0, 0.0))
        self.ms = 0
        self.verb = codes.STOP
        self.wall: float | None = None
        self.unseen = False
        self.fastest_mm_s = 0.0
        self._gone_mm = 0.0
        self._seen: tuple[float, ...] = ()
        for field in FIELDS:
            setattr(self.i, f"clearance_{field}", CLEAR_FAR)

    def way(self) -> float:
        """How far it has come in the direction of the motion, from where the world began."""
        c = self.chair
        if self.verb in (codes.LEFT, codes.RIGHT):
            return c.heading_deg * (16 if self.verb == codes.LEFT else -16)
        return self._gone_mm if self.verb == codes.FORWARD else -self._gone_mm

    def one_ms(self, pressed: bool) -> bool:
        """A tick and what the chair makes of it; True while the motion is permitted."""
        self.ms += 1
        i, motion = self.i, self.motion
        if self.ms % 10 == 0:
            i.heading_count = (i.heading_count + 1) & 0xFFFF
            i.heading_q4 = round(self.chair.heading_deg * 16) % 5760
            i.rate_q4 = round(self.chair.yaw_rate_deg_s * 16)
        if self.ms % LOOK_MS == 0:
            self._look()
        obstacles = self.obstacles
        out = (motion.linear_permille, motion.turn_permille)
        obstacles.step(i, *out, True, self.check.agreed, self.check.sluggish)
        free = pressed and not obstacles.blocked & (1 << VERBS.index(self.verb))
        if free:
            motion.step(i, obstacles.blocked, obstacles.caps)
        else:
            motion.stop()
        self.check.step(i, motion.linear_permille, motion.turn_permille)
        stick = (motion.linear_permille / 1000, motion.turn_permille / 1000)
        self.chair.step(0.001, stick)
        self._gone_mm += self.chair.speed_m_s
        corner = abs(self.chair.yaw_rate_deg_s) * 16 * Q4_DEG_MM
        self.fastest_mm_s = max(self.fastest_mm_s, abs(self.chair.speed_m_s) * 1000, corner)
        return free

    def _look(self) -> None:
        i = self.i
        i.clearance_count = (i.clearance_count + 1) & 0xFFFF
        i.clearance_age_ms = AGE_MS
        i.clearance_unseen = 15 if self.unseen else 0
        if self.wall is None:
            return
        # As it was AGE_MS ago.
        self._seen = (*self._seen[-(AGE_MS // LOOK_MS) :], self.wall - self.way())
        field = FIELDS[VERBS.index(self.verb)]
        setattr(i, f"clearance_{field}", max(0, min(CLEAR_FAR, int(self._seen[0]))))

    def press(self, verb: int, mode: int = codes.CONTINUOUS) -> None:
        """A new press; the motion begins anew."""
        self.verb = verb
        self.i.verb, self.i.mode = verb, mode
        self.i.edge = self.i.edge % 255 + 1

    def run(self, ms: int, pressed: bool) -> None:
        """Let `ms` pass; a press that ended is pressed anew half a second later."""
        rest_ms = 0
        for _ in range(ms):
            held = pressed and rest_ms == 0
            if rest_ms:
                rest_ms -= 1
                if rest_ms == 0:
                    self.press(self.verb)
            if not self.one_ms(held) and held:
                rest_ms = 500

    def gap(self) -> float:
        """What is left to the wall."""
        return math.inf if self.wall is None else self.wall - self.way()


def legal(dice: random.Random) -> Any:
    """Random settings, each through the door that settings come through.

    A row of the chair often has one extreme in all profiles: what a single careless edit makes.
    Every other time all extremes are those that make the chair look tame.
    """
    settings: Any = Settings()
    tame = dice.random() < 0.5
    everywhere = {name: dice.choice((None, 0, 1)) for name, _low, _high in PROFILE_ROWS}
    for index, (name, _default, low, high) in enumerate(TABLE):
        if name in NEUTRAL or dice.random() < 0.05:
            continue
        value = dice.choice((low, high, dice.randint(low, high), dice.randint(low, high)))
        row = name[len(PREFIX) :] if name[1:2].isdigit() else name
        extreme = everywhere.get(row)
        if tame and row.split("_")[0] in LOW + HIGH:
            extreme = int(row.split("_")[0] in HIGH)
        if extreme is not None:
            value = (low, high)[extreme]
        assert settings.set(index, value) == codes.NO_REASON, name
    return settings


@some_seeds
@pytest.mark.parametrize("profile", PROFILES)
def test_no_settings_make_it_touch_a_wall_that_is_seen(profile: str, seeds: range) -> None:
    for seed in seeds:
        dice = random.Random(f"wall {profile} {seed}")
        run = Fuzzed(legal(dice), profile, seed)
        if seed % 2:
            run.press(dice.choice((codes.LEFT, codes.RIGHT)))
            run.run(3500, True)
            run.run(1500, False)
        verb = dice.choice(VERBS)
        run.press(verb)
        run.wall = run.way() + dice.choice((300, 1200, 2500, 2500))
        run.run(400, False)
        least = math.inf
        for _ in range(60):
            run.run(100, True)
            least = min(least, run.gap())
        assert least > 0, (seed, verb, least, run.check.agreed)


@some_seeds
@pytest.mark.parametrize("profile", PROFILES)
def test_no_settings_make_creep_fast(profile: str, seeds: range) -> None:
    for seed in seeds:
        dice = random.Random(f"creep {profile} {seed}")
        run = Fuzzed(legal(dice), profile, seed)
        run.unseen = True
        for _ in range(2):
            run.press(dice.choice(VERBS))
            run.run(2500, True)
        assert run.fastest_mm_s <= limits.CREEP_MOST_MM_S + GRAIN_MM_S, seed


@some_seeds
@pytest.mark.parametrize("profile", PROFILES)
def test_no_settings_make_it_fast_without_a_relay(profile: str, seeds: range) -> None:
    for seed in seeds:
        dice = random.Random(f"relay {profile} {seed}")
        settings = legal(dice)
        settings.relay_fitted = 0
        run = Fuzzed(settings, profile, seed)
        for _ in range(2):
            run.press(dice.choice(VERBS))
            run.run(2500, True)
        assert run.fastest_mm_s <= limits.CREEP_MOST_MM_S + GRAIN_MM_S, seed
