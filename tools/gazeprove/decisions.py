"""Every decision of the obstacle rule from every level, held against its rules in plain words."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from gazeboard.core.obstacles import Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.core.stopping import LEVELS, Stopping
from gazeboard.io.settings import Settings
from gazelink import codes
from gazelink.messages import CLEAR_FAR

_AGES_MS = (0, 240)
_BITS = ((0, 0), (0, 1), (1, 0), (1, 1))  # blocked, unseen
_FIELDS = (
    "clearance_forward_mm",
    "clearance_backward_mm",
    "clearance_left_q4",
    "clearance_right_q4",
)
_STORIES = 10
_ROUNDED = 3  # units: the way moved and both terms of the way to stop are each rounded down


@dataclass
class Decided:
    """Decisions made, and what did not hold."""

    decisions: int = 0
    broken: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Case:
    """One turn of one direction: what was before, what it is told, what came of it."""

    level: int
    speed: int
    distance: int
    age_ms: int
    blocked: int
    unseen: int
    bypass: bool
    waited: bool
    after: int
    cap: int
    decision: int


def settings_tried(quick: bool) -> list[Settings]:
    """The defaults; a slow chair without a relay; the widest of all; one that cannot creep."""
    wide = Settings()
    bare = Settings()
    bare.__dict__.update(relay_fitted=0, profile=0, creep_mm_s=50, reaction_ms=200)
    wide.__dict__.update(stop_margin_mm=500, stop_margin_q4_deg=160, reaction_ms=1000)
    stiff = Settings()  # what starts it is more than creep
    stiff.__dict__.update(p3_1_deadband_permille=300, p3_1_forward_mm_s=800)
    return [Settings()] if quick else [Settings(), bare, wide, stiff]


def explore(settings: Settings, quick: bool) -> Decided:
    """Every level x bypass x bits x age x speeds and distances around each place that matters."""
    found = Decided()
    obstacles: Any = Obstacles(settings)
    for trusted, direction in itertools.product((False, True), range(4)):
        stopping = obstacles._stopping[direction + 4 if trusted else direction]
        for speed in _speeds(stopping, quick):
            last: dict[tuple[Any, ...], int] = {}
            for case in _turns(obstacles, direction, stopping, speed, quick):
                found.decisions += 1
                broken = _broken(case, stopping)
                # More way never allows less, all else the same.
                key = (case.level, case.age_ms, case.blocked, case.unseen, case.bypass, case.waited)
                if case.cap < last.get(key, 0):
                    broken.append("more way allows less")
                last[key] = case.cap
                found.broken += [f"direction {direction} {text}: {case}" for text in broken]
                if len(found.broken) > _STORIES:
                    return found
    return found


def _speeds(stopping: Stopping, quick: bool) -> list[int]:
    full = stopping.full
    creep = stopping.creep
    return [0, full // 2] if quick else [0, creep, 2 * creep, 2 * creep + 1, full]


def _distances(stopping: Stopping, speed: int, quick: bool) -> list[int]:
    """In ascending order: below, at and above every place at which a decision changes."""
    places = {*stopping.begin, stopping.margin, stopping.stop(speed)}
    if quick:
        places = set(sorted(places)[::6])
    moved = {speed * age_ms // 1000 for age_ms in _AGES_MS}
    near = {
        place + ahead + band + off
        for place in places
        for ahead in moved
        for band in (0, stopping.band)
        for off in (-1, 0)
    }
    return sorted({0, CLEAR_FAR} | {max(0, min(CLEAR_FAR, place)) for place in near})


def _turns(
    obstacles: Any, direction: int, stopping: Stopping, speed: int, quick: bool
) -> Iterator[Case]:
    way = obstacles._ways[direction]
    inputs: Any = Inputs()
    way.speed = speed
    way.stop = stopping.stop(speed)
    levels = range(-1, LEVELS + 1, 6 if quick else 1)
    bypasses = (False, True)
    for distance in _distances(stopping, speed, quick):
        setattr(inputs, _FIELDS[direction], distance)
        for level, age_ms, (blocked, unseen), bypass, waited in itertools.product(
            levels, _AGES_MS, _BITS, bypasses, bypasses
        ):
            inputs.clearance_blocked = blocked << direction
            inputs.clearance_unseen = unseen << direction
            way.level = level
            way._better_ms = 1000 if waited else 0
            obstacles._age_ms = age_ms - 2  # a turn counts two ticks
            obstacles.bypass.left_ms = 100 if bypass else 0
            obstacles._judge(inputs, direction, way, stopping)
            decision = obstacles.decisions >> (2 * direction) & 3
            cap = obstacles.caps[direction]
            yield Case(
                level,
                speed,
                distance,
                age_ms,
                blocked,
                unseen,
                bypass,
                waited,
                way.level,
                cap,
                decision,
            )


def _broken(c: Case, stopping: Stopping) -> list[str]:
    """The rules that a turn broke, as docs/obstacles.md has them: not taken from the code."""
    left = c.distance - c.speed * c.age_ms / 1000
    stop = c.speed * stopping.time_ms / 1000 + c.speed**2 / (2 * stopping.brake) + stopping.margin
    creeping = c.bypass and c.speed <= 2 * stopping.creep
    creep = stopping.permille[0]
    cap_speed = min(1000, c.cap) * stopping.full / 1000
    rules = {
        "a blocked bit lets nothing pass without a bypass": (
            not c.blocked or c.cap == (creep if creeping else 0)
        ),
        "nothing is let pass that cannot stop": c.cap == 0 or creeping or left > stop - _ROUNDED,
        "an arc never seen is crept into": not c.unseen or c.cap <= creep,
        "a bypass creeps": not c.bypass or c.cap <= max(creep, stopping.permille[max(0, c.after)]),
        "a bypass of a slow chair is creep": not creeping or c.cap == creep,
        "the decision says what the cap does": c.decision
        == (
            codes.BLOCKED
            if c.cap == 0
            else codes.FREE
            if c.after == LEVELS and not creeping
            else codes.SLOW
        ),
        "up only after the wait": c.after <= c.level or c.waited,
        "up only with a band to spare": c.after <= c.level
        or left - stopping.band >= stopping.begin[c.after] - 1,
        "no more than the way allows": creeping
        or c.cap == 0
        or c.after == LEVELS
        or left >= cap_speed * stopping.time_ms / 1000 + stopping.margin - 2,
        "free only with the whole way": c.decision != codes.FREE
        or (left >= stopping.begin[LEVELS] - 1 and not c.blocked and not c.unseen),
        "blocked only for a reason": c.cap > 0
        or (c.after <= 0 and creep == 0)
        or (creeping and creep == 0)
        or c.blocked
        or c.level < 0
        or left < max(stop, stopping.begin[0]) + 1,
    }
    return [f"not: {name}" for name, holds in rules.items() if not holds]
