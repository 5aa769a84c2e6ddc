"""A simulated driver who drives by gaze: their aim, their gaze, and the page's response.

The page's part (a dwell begins a press, a look away ends it) uses a profile's own times:
dwell 600 ms, steering while moving 200 ms, leave grace 200 ms, a still pointer counts as gone after
500 ms (gazechair.people.profiles; web/targets.js). The person's part, each with its source or [E],
an estimate that was never measured with a driver:

- latency of a look: 0.2 s for a saccade to begin (0.15-0.25 s, textbook value) and 0.15 s [E] to
  decide, standard deviation 0.08 s [E];
- blinks: one in 4 s on average (15-20 a minute), 0.1-0.3 s long; the pointer stands still;
- tracker dropouts: one in 30 s, 0.3-2 s long [E] (dyskinetic users: design for dropouts and head
  movement, shared facts); the pointer stands still;
- spasms: one in 60 s, 0.5-1.5 s [E]: the gaze leaves all targets;
- wrong looks: 5 of 100 turns go to the other side first, noticed after 0.6-1.2 s [E];
- judging a direction: 2.5 degrees standard deviation [E], judged again every 1.5 s;
- turns are held by feel: 15 % standard deviation of the time [E], as in scanning_person;
- after the chair has ended a press they aim again, to 2 degrees by their judgement (helped: 8);
  after it has ended a turn they drive forward first, up to half a metre [E];
- they let go of a motion that moves nothing for 1 s, and look away for 0.5 s; not while the tile
  that they look at says that assist waits for what may be a person and they see that it is a thing:
  then they hold on, for up to 15 s [E] (it takes 10 s; a press held for that long is usual);
- when the chair has ended three presses in one place, helped or not, they back away for about 2 s
  and aim again [E]: the page says that something is in the way.

One seed determines all random events of a driver. Each kind of event has its own random stream, so
that the same events happen at the same times with and without help. `helped`: the driver knows that
the chair steers: they point roughly, look further ahead, and correct later.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from gazechair.base.angles import half_turn_deg

DWELL_S, GRACE_S, STALE_S = 0.6, 0.2, 0.5
_LOOK_S, _LOOK_SD_S = 0.35, 0.08
_BLINK_EVERY_S, _BLINK_S = 4.0, (0.1, 0.3)
_DROPOUT_EVERY_S, _DROPOUT_S = 30.0, (0.3, 2.0)
_SPASM_EVERY_S, _SPASM_S = 60.0, (0.5, 1.5)
_WRONG, _WRONG_S = 0.05, (0.6, 1.2)
_JUDGE_DEG, _JUDGE_S = 2.5, 1.5
_TURN_SD = 0.15
_STUCK_S, _AWAY_S = 1.0, 0.5
_PATIENT_S = 15.0
_COAST_S = 0.3
_PASSED_M = 0.35  # this near to a point of the route they look at the next
_NEAR_M = 0.12
_GOAL_M = 0.5
_SAME_PLACE_M, _TRIES, _BACK_S, _BACK_SD_S = 0.10, 3, 2.0, 0.3
_BEGIN_DEG, _LEAVE_DEG = 6.0, 9.0  # off the direction: turns first; stops to correct
_CAREFUL_DEG = (2.0, 8.0)
_PAST_DEG, _PAST_M = 35.0, 0.5
_HELPED_DEG, _HELPED_LEAVE_DEG = 18.0, 35.0

Point = tuple[float, float]


@dataclass(frozen=True)
class Seen:
    """What the driver sees: the chair's true pose, and the page."""

    x_m: float
    y_m: float
    heading_deg: float
    moves: bool
    turn_deg_s: float
    """The chair's rate in a held turn, as the driver has learnt it."""
    waits: bool = False
    """The tile of Vooruit says that assist waits for what may be a person; here it is a thing."""


class GazeDriver:
    """Call `tick` every 25 ms or more often; `held` is the press that the page holds."""

    def __init__(self, seed: int, route: Sequence[Point], helped: bool) -> None:
        """`route`: the points that the driver wants to pass; the last one is the goal."""
        self._route = list(route)
        self._helped = helped
        self._looks, self._judges, self._turns = (
            random.Random(f"{seed} {kind}") for kind in ("looks", "judges", "turns")
        )
        self._troubles = [
            _Trouble(random.Random(f"{seed} {every}"), every, lasts)
            for every, lasts in (
                (_BLINK_EVERY_S, _BLINK_S),
                (_DROPOUT_EVERY_S, _DROPOUT_S),
                (_SPASM_EVERY_S, _SPASM_S),
            )
        ]
        self.commands = 0
        """Presses that began."""
        self.held: str | None = None
        """The press that the page holds now: "forward", "backward", "left", "right"."""
        self._target: str | None = None  # looked at
        self._next: tuple[float, str | None] | None = None
        self._fixed_s = 0.0  # since when on that target
        self._left_s: float | None = None  # since when the pointer is off the held target
        self._fresh_s = 0.0
        self._error_deg = 0.0
        self._judged_s = -math.inf
        self._until_s = 0.0
        self._wrong_till_s = 0.0
        self._moved_s = 0.0
        self._away_till_s = 0.0
        self._ended = False
        self._past_deg = 0.0  # the chair ended a turn: drives forward first if not farther off
        self._careful = False  # the chair ended a press: aims better before the next
        self._ended_at: Point | None = None  # where it ended presses
        self._ended_here = 0
        self._backs = False  # backs away from there

    @property
    def arrived(self) -> bool:
        """True if the driver has passed the last point."""
        return not self._route

    def ended(self) -> None:
        """The chair has ended the press: the driver must look away and press again."""
        self._ended = True

    def tick(self, now_s: float, seen: Seen) -> str | None:
        """The press that the page holds now, None for none."""
        blink, dropout, spasm = (trouble.on(now_s) for trouble in self._troubles)
        if not (blink or dropout):
            self._fresh_s = now_s
        self._pass(seen)
        self._look(now_s, seen, spasm)
        self._page(now_s, None if spasm else self._target)
        return self.held

    def _pass(self, seen: Seen) -> None:
        while self._route:
            x, y = self._route[0]
            dx, dy = x - seen.x_m, y - seen.y_m
            far = math.hypot(dx, dy)
            if len(self._route) > 1:
                # Also passed: behind it, seen towards the next one.
                nx, ny = self._route[1]
                behind = dx * (nx - x) + dy * (ny - y) < 0.0 and far < 1.0
                near = _PASSED_M if self._helped else _NEAR_M
                if far < near or behind:
                    self._route.pop(0)
                    continue
            elif far < _GOAL_M:
                self._route.pop(0)
                continue
            return

    def _off_deg(self, seen: Seen) -> float:
        x, y = self._route[0]
        bearing = math.degrees(math.atan2(y - seen.y_m, x - seen.x_m))
        return half_turn_deg(bearing - seen.heading_deg) + self._error_deg

    def _wants(self, now_s: float, seen: Seen) -> str | None:
        if self.arrived or now_s < self._away_till_s:
            return None
        off_deg = self._off_deg(seen)
        begin, leave = (
            (_HELPED_DEG, _HELPED_LEAVE_DEG) if self._helped else (_BEGIN_DEG, _LEAVE_DEG)
        )
        more_deg = leave - begin
        if self._careful:
            begin = _CAREFUL_DEG[self._helped]
        at = self._ended_at
        if at is not None and math.dist(at, (seen.x_m, seen.y_m)) > _PAST_M:
            self._past_deg = 0.0
        if self._past_deg:
            leave = self._past_deg + more_deg
            begin = self._past_deg if abs(off_deg) < self._past_deg else begin
        if self.held == "forward":
            return "forward" if abs(off_deg) < leave else None
        if self.held in ("left", "right", "backward"):
            return self.held if now_s < self._until_s else None
        if self._backs:
            return "backward"
        if abs(off_deg) < begin:
            return "forward"
        right = off_deg < 0.0
        if now_s < self._wrong_till_s:
            right = not right
        return "right" if right else "left"

    def _look(self, now_s: float, seen: Seen, spasm: bool) -> None:
        if seen.moves or self.held is None:
            self._moved_s = now_s
        self._careful |= self._ended
        if self._ended:
            self._past_deg = _PAST_DEG if self.held in ("left", "right") else 0.0
            self._count_ends(seen)
        patient_s = _PATIENT_S if seen.waits else _STUCK_S
        if self._ended or (self.held and now_s - self._moved_s > patient_s):
            self._ended = False
            self._away_till_s = now_s + _AWAY_S
            self._target, self._next = None, None
            self.held = None
        wanted = self._wants(now_s, seen)
        if self.held is None and seen.moves:
            wanted = None  # waits until the chair stands
        if wanted != self._target and self._next is None and not spasm:
            delay_s = max(0.15, self._looks.gauss(_LOOK_S, _LOOK_SD_S))
            if now_s >= self._judged_s + _JUDGE_S:
                self._error_deg, self._judged_s = self._judges.gauss(0.0, _JUDGE_DEG), now_s
            if wanted in ("left", "right") and self._looks.random() < _WRONG:
                self._wrong_till_s = now_s + delay_s + self._looks.uniform(*_WRONG_S)
            self._next = now_s + delay_s, wanted
        if self._next is not None and now_s >= self._next[0]:
            target = None if self.arrived else self._next[1]  # it may have rolled there meanwhile
            self._next = None
            if target != self._target:
                self._target, self._fixed_s = target, now_s
                self._careful &= target is None
                if target == "backward":
                    back_s = max(0.5, self._turns.gauss(_BACK_S, _BACK_SD_S))
                    self._until_s = now_s + DWELL_S + back_s
                    self._past_deg = 0.0
                elif target in ("left", "right"):
                    hold_s = abs(self._off_deg(seen)) / max(3.0, seen.turn_deg_s)
                    hold_s = max(0.25, hold_s * self._turns.gauss(1.0, _TURN_SD) - _COAST_S)
                    self._until_s = now_s + DWELL_S + hold_s

    def _count_ends(self, seen: Seen) -> None:
        before, here = self._ended_at, (seen.x_m, seen.y_m)
        again = before is not None and math.dist(before, here) < _SAME_PLACE_M
        self._ended_here = self._ended_here + 1 if again else 1
        if not again:
            self._ended_at = here
        # If backing away failed too, the driver tries everything again.
        self._backs = self._ended_here >= _TRIES and self.held != "backward"
        if self._backs:
            self._ended_here = 0

    def _page(self, now_s: float, pointer: str | None) -> None:
        if self.held is not None:
            if pointer == self.held:
                self._left_s = None
            elif self._left_s is None:
                self._left_s = now_s
            gone = self._left_s is not None and now_s - self._left_s > GRACE_S
            if gone or now_s - self._fresh_s > STALE_S:
                self.held, self._left_s = None, None
                self._fixed_s = now_s
        elif pointer is None or now_s - self._fresh_s > GRACE_S:
            self._fixed_s = now_s
        elif now_s - self._fixed_s >= DWELL_S:
            self.held, self._left_s = pointer, None
            self._backs &= pointer != "backward"
            self.commands += 1
            self._moved_s = now_s


class _Trouble:
    """A disturbance that begins at random and lasts for a while."""

    def __init__(self, chance: random.Random, every_s: float, lasts_s: tuple[float, float]) -> None:
        self._chance = chance
        self._every_s = every_s
        self._lasts_s = lasts_s
        self._from_s = chance.expovariate(1.0 / every_s)
        self._to_s = self._from_s + chance.uniform(*lasts_s)

    def on(self, now_s: float) -> bool:
        while now_s >= self._to_s:
            self._from_s = self._to_s + self._chance.expovariate(1.0 / self._every_s)
            self._to_s = self._from_s + self._chance.uniform(*self._lasts_s)
        return now_s >= self._from_s
