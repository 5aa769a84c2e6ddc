"""Breadth-first through every reachable abstract state of the real core, every event in each."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from gazelink import codes
from gazeprove import abstract
from gazeprove.abstract import FIELDS, State
from gazeprove.events import begin, first_state, tick
from gazeprove.inputs import Scope
from gazeprove.invariants import INVARIANTS
from gazeprove.seen import After

_NOTE_EVERY_S = 5.0
_STATE = FIELDS.index("state")


@dataclass
class Explored:
    """What was found in one scope. `edges`: pairs of state numbers. `broken`: what did not hold."""

    scope: Scope
    states: dict[State, int] = field(default_factory=dict)
    edges: set[tuple[int, int]] = field(default_factory=set)
    transitions: int = 0
    ticks: int = 0  # in which these were: what nobody asked for is both in one
    broken: list[str] = field(default_factory=list)
    dead_ends: int = 0
    seconds: float = 0.0


def explore(scope: Scope, note: Callable[[str], None] = lambda text: None) -> Explored:
    """Every state that the scope's causes can lead to. Stops at the tenth broken invariant."""
    started = noted = time.monotonic()
    core, inputs, choices, first = first_state(scope)
    found = Explored(scope, {first: 0})
    order = [first]
    back: defaultdict[int, set[int]] = defaultdict(set)  # by ticks in which all is well
    goals: set[int] = set()
    numbers: dict[tuple[Any, ...], tuple[int, ...]] = {}  # of the states that something seen may be
    safety = core.safety
    number = 0
    while number < len(order) and len(found.broken) < 10:
        begin(core, order[number], scope, inputs)
        reached: set[int] = set()
        well: set[int] = set()
        while True:
            facts, was = tick(core, scope, inputs, choices)
            after = After.of(was, core, inputs.read, facts, scope)
            for invariant in INVARIANTS:
                if not invariant(after):
                    found.broken.append(_story(invariant.__name__, after))
            found.ticks += 1
            found.transitions += core.together()
            seen = core.seen()
            indices = numbers.get(seen)
            if indices is None:
                for state in core.states(seen):
                    if state not in found.states:
                        found.states[state] = len(order)
                        order.append(state)
                indices = tuple({found.states[state] for state in core.states(seen)})
                numbers[seen] = indices
            reached.update(indices)
            if facts.well:
                well.update(indices)
                if after.moving and safety.state == codes.ARMED:
                    goals.update(indices)
            if not choices.following():
                break
        found.edges.update((number, index) for index in reached)
        for index in well:
            back[index].add(number)
        number += 1
        if time.monotonic() - noted > _NOTE_EVERY_S:
            noted = time.monotonic()
            note(f"{scope.name}: {number} of {len(order)} states, {found.transitions} transitions")
    if scope.never_drives:
        if goals:
            found.broken.append("it drives, and never may")
        found.seconds = time.monotonic() - started
        return found
    found.dead_ends = len(order) - len(_leading_to(goals, back))
    if found.dead_ends and not found.broken:
        alive = _leading_to(goals, back)
        lost = next(state for state, index in found.states.items() if index not in alive)
        found.broken.append(f"no way back to driving from {describe(lost)}")
    found.seconds = time.monotonic() - started
    return found


def _leading_to(goals: set[int], back: dict[int, set[int]]) -> set[int]:
    """States from which a goal can be reached."""
    reached = set(goals)
    todo = list(goals)
    while todo:
        for before in back.get(todo.pop(), ()):
            if before not in reached:
                reached.add(before)
                todo.append(before)
    return reached


def describe(state: State) -> str:
    """A state in words: the fields that are not 0."""
    names = (*FIELDS, *(f"motion.{name}" for name in abstract.MOTION_FIELDS), *abstract.AUTO_FIELDS)
    return " ".join(f"{n}={v:d}" for n, v in zip(names, state, strict=True) if v)


def _story(invariant: str, a: After) -> str:
    a.core.toss()
    inputs = dict(a.read)
    if "clearance_blocked" in inputs:
        inputs["clearance_blocked"] = inputs["clearance_blocked"].known
    return (
        f"{invariant}\n    before: {describe(a.core.state)}\n    inputs: {inputs}\n"
        f"    facts:  {a.facts}\n    after:  {describe(a.core.read())}"
        f" output=({a.linear}, {a.turn}) override={a.core.safety.override}"
    )
