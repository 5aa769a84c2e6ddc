"""Random runs of the concrete core, tick by tick in virtual time, held against what was explored.

Nothing is abstracted while it runs: counters count, inputs stay until they change. Each tick's
abstraction must be one of the explored transitions, and every invariant must hold.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Any

from gazeboard.core.shared import Inputs
from gazelink import codes
from gazeprove.around import Facts
from gazeprove.core import Core
from gazeprove.events import first_state, run
from gazeprove.explore import Explored, describe
from gazeprove.inputs import CAUSES, Blocked, Choices, Scope
from gazeprove.invariants import INVARIANTS
from gazeprove.seen import After

# How long trouble lasts: around every deadline, and in between.
_LASTS_MS = (1, 2, 3, 24, 26, 47, 49, 97, 99, 120, 149, 297, 299, 300, 330, 497, 499, 510, 620)


@dataclass
class Walked:
    """Ticks run, how many of them moved the chair, and what went wrong."""

    ticks: int = 0
    moving: int = 0
    broken: list[str] = field(default_factory=list)


class Walk:
    """One random life of the core under a scope's causes."""

    def __init__(self, scope: Scope, explored: Explored | None, seed: int) -> None:
        self._scope = scope
        self._explored = explored
        self._random = random.Random(seed)
        self._choices = _RandomChoices(self._random)
        self._core = self._built()
        self._i = Inputs()
        self._i.cap_permille = 1000
        self._i.calibrated = True
        self._trouble: dict[str, int] = {}  # ticks left of each cause
        self._next_trouble = 900
        self._hold_ms = 0
        self._watches = True
        self.found = Walked()

    def _built(self) -> Core:
        core, _, _, _ = first_state(self._scope)
        core.motion._turn._choices = self._choices
        return core

    def run(self, ticks: int) -> Walked:
        """Go on for so many ticks, or until something is broken."""
        before = self._core.read()
        for _ in range(ticks):
            was = self._core.safety.fields()
            facts = self._tick()
            after = self._seen(was, facts)
            self.found.ticks += 1
            self.found.moving += after.moving
            broken = [check.__name__ for check in INVARIANTS if not check(after)]
            now = self._core.read()
            if self._explored is not None and not self._was_explored(before, now):
                broken.append("a transition that was not explored")
            if broken:
                story = f"{', '.join(broken)}: {describe(before)}  ->  {describe(now)} {facts}"
                self.found.broken.append(story)
                break
            before = now
        return self.found

    def _was_explored(self, before: Any, now: Any) -> bool:
        assert self._explored is not None
        states = self._explored.states
        return (states.get(before, -1), states.get(now, -1)) in self._explored.edges

    def _tick(self) -> Facts:
        strikes = self._struck()
        i, core = self._i, self._core
        facts = Facts(
            contact=(core.safety.enable and self._scope.relay_fitted) != strikes["relay"],
            emergency_open=strikes["emergency"] and self._random.random() < 0.5,
            message=strikes["emergency"] and self._random.random() < 0.5,
            button=strikes["button"],
            late=strikes["late"],
            disarm=False,
            arms=0,
            reset=False,
            stopped=strikes["stop"],
            new_session=strikes["session"] or i.session_count == 0,
        )
        self._live(facts)
        self._fill(strikes, facts)
        raised = strikes["exception"]
        facts.raised = raised
        facts.stepped = not raised or self._random.random() < 0.5
        run(core, i, facts, strikes.__getitem__)
        return facts

    def _struck(self) -> dict[str, bool]:
        """Which causes strike in this tick."""
        roll = self._random
        self._next_trouble -= 1
        if self._next_trouble <= 0 and self._scope.causes:
            self._next_trouble = roll.choice((1, 60, 400, 900, 1600))
            causes = sorted(self._scope.causes)
            for cause in {roll.choice(causes) for _ in range(roll.choice((1, 1, 2)))}:
                once = cause in ("session", "stop", "exception", "late", "often", "obeys")
                lasts = 1 if once else roll.choice(_LASTS_MS)
                if cause == "button":
                    lasts = roll.choice((10, 2999, 3000, 3100))
                elif cause == "wiper":
                    lasts = roll.choice((1, 2, 3, 4))
                self._trouble[cause] = lasts
        struck = dict.fromkeys(CAUSES, False)
        for cause in list(self._trouble):
            struck[cause] = True
            self._trouble[cause] -= 1
            if not self._trouble[cause]:
                del self._trouble[cause]
        return struck

    def _live(self, facts: Facts) -> None:
        """What the people do: rest, reset, arm, press, hold, let go, press something else."""
        roll, i, safety = self._random, self._i, self._core.safety
        if self._hold_ms > 0:
            self._hold_ms -= 1
            if roll.random() < 0.05:
                self._command(roll.choice((0, 1, 2, 3, 50, 300)))
        elif i.verb != codes.STOP and roll.random() < 0.02:
            i.verb = codes.STOP
        if safety.state == codes.DISARMED and roll.random() < 0.01:
            i.verb = codes.STOP
            self._hold_ms = 0
            reset = safety.faults != 0 and roll.random() < 0.5
            self._order(codes.RESET_FAULTS if reset else codes.ARM, facts)
        elif roll.random() < 0.001:
            self._order(roll.choice((codes.DISARM, codes.ARM)), facts)
            if self._scope.all_commands and roll.random() < 0.3:
                self._order(roll.choice((codes.DISARM, codes.ARM, codes.RESET_FAULTS)), facts)
        elif roll.random() < (0.03 if safety.state == codes.ARMED else 0.002):
            self._press(facts)
        if "auto" in self._scope.causes and safety.state == codes.ARMED:
            self._watch(facts)

    def _order(self, action: int, facts: Facts) -> None:
        i = self._i
        if action == codes.RESET_FAULTS:
            facts.reset = True
            i.reset_count = (i.reset_count + 1) & 0xFFFF
        elif action == codes.DISARM:
            facts.disarm = True
            i.disarm_count = (i.disarm_count + 1) & 0xFFFF
        else:
            facts.arms += 1
            i.arm_count = (i.arm_count + 1) & 0xFFFF
            caretaker = self._scope.all_commands and self._random.random() < 0.2
            i.arm_owner = codes.CARETAKER if caretaker else codes.DRIVER

    def _watch(self, facts: Facts) -> None:
        """Somebody supervises, mostly; and there are presses that are no command."""
        roll, i = self._random, self._i
        if roll.random() < 0.002:
            self._pressed(facts)
        if roll.random() < (0.05 if self._watches else 0.0002):
            i.supervision_edge = i.edge if roll.random() < 0.99 else roll.randrange(256)
            i.supervision_age_ms = roll.choice((0, 0, 0, 100, 2000))
            i.supervision_count = (i.supervision_count + 1) & 0xFFFF
        if roll.random() < 0.0005:
            self._watches = not self._watches

    def _pressed(self, facts: Facts) -> None:
        self._i.press_count = (self._i.press_count + 1) & 0xFFFF
        facts.presses += 1

    def _press(self, facts: Facts) -> None:
        roll, i, safety = self._random, self._i, self._core.safety
        full = self._scope.all_commands
        i.verb = roll.randrange(7) if full else roll.choice((codes.FORWARD, codes.LEFT))
        i.mode = codes.CONTINUOUS if i.verb == codes.FORWARD else codes.STEP
        if full:
            i.mode = roll.randrange(2)
            i.owner = roll.choice((codes.DRIVER, codes.DRIVER, codes.CARETAKER, codes.NOBODY))
            i.linear_permille = roll.choice((-1000, 0, 1000))
            i.turn_permille = roll.choice((-1000, 0, 1000))
        else:
            i.owner = codes.DRIVER
        if "auto" in self._scope.causes and roll.random() < 0.5:
            i.verb = roll.choice((codes.DRIVE, codes.DRIVE, codes.DRIVE, codes.FORWARD))
            i.mode = roll.choice((codes.AUTO, codes.AUTO, codes.CONTINUOUS))
            i.owner = codes.DRIVER
            i.linear_permille = roll.choice((-1000, 0, 1000))
            i.turn_permille = roll.choice((-1000, 0, 1000))
            i.clearance_unseen = roll.choice((0, 0, 0, roll.randrange(16)))
        self._pressed(facts)
        newest = safety.edge or safety.spent_edge
        new = (newest + roll.randrange(120)) % 255 + 1
        i.edge = roll.choice((new, new, roll.randrange(256), safety.edge, safety.spent_edge, 0))
        i.clearance_blocked = roll.choice((0, 0, 0, roll.randrange(16)))
        self._hold_ms = roll.choice((0, 20, 350, 2500, 7000))
        self._command(300)

    def _command(self, ttl_ms: int) -> None:
        self._i.ttl_ms = ttl_ms
        self._i.command_count = (self._i.command_count + 1) & 0xFFFF

    def _fill(self, strikes: dict[str, bool], facts: Facts) -> None:
        i, roll = self._i, self._random
        if not strikes["host"]:
            i.host_count = (i.host_count + 1) & 0xFFFF
        if not strikes["service"]:
            i.service_count = (i.service_count + 1) & 0xFFFF
        if not strikes["lidar"]:
            i.clearance_count = (i.clearance_count + 1) & 0xFFFF
            i.clearance_age_ms = roll.randrange(400) if "lidar" in self._trouble else 0
        if not strikes["imu"]:
            i.heading_count = (i.heading_count + 1) & 0xFFFF
        i.clearance_source = codes.SIMULATED if strikes["source"] else codes.REAL
        i.heading_faults = 1 << codes.HEADING_FROZEN if strikes["heading"] else 0
        i.tilted = strikes["tilt"]
        i.service_faults = 1 << codes.TILT_UNKNOWN if strikes["tilt"] and roll.random() < 0.5 else 0
        i.calibrated = not strikes["calibration"]
        if facts.message:
            i.emergency_count = (i.emergency_count + 1) & 0xFFFF
        if facts.stopped:
            i.stop_edge = roll.choice((i.edge, i.edge, 0, roll.randrange(256)))
            i.stop_count = (i.stop_count + 1) & 0xFFFF
        if facts.new_session:
            i.session_count = (i.session_count + 1) & 0xFFFF or 1

    def _seen(self, was: dict[str, Any], facts: Facts) -> After:
        read = dict(self._i.__dict__)
        blocked = Blocked(self._choices)
        unseen = Blocked(self._choices)
        for bit in (1, 2, 4, 8):
            blocked.known[bit] = read["clearance_blocked"] & bit
            unseen.known[bit] = read["clearance_unseen"] & bit
        read["clearance_blocked"] = blocked
        read["clearance_unseen"] = unseen
        return After.of(was, self._core, read, facts, self._scope)


class _RandomChoices(Choices):
    """Answers at random: for the turn controller."""

    def __init__(self, source: random.Random) -> None:
        super().__init__()
        self._source = source

    def pick(self, size: int) -> int:
        """A number below `size`; the last one, which ends a turn, is rare."""
        return self._source.randrange(size) if self._source.random() < 0.002 else 1
