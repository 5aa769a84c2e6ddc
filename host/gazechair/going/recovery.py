"""Recovery: what a mission does where the board gives no output, or output moves no chair."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np

from gazechair.going.costmap import Costmap
from gazechair.going.follow import STOP, Follower, Stick
from gazechair.going.obstacle_layer import ObstacleLayer
from gazechair.going.plan import NO_WAY, Planner, Pose
from gazechair.going.refusals import Refusals
from gazechair.going.rolled import Rolled
from gazechair.going.standing import PATIENCE_S
from gazechair.going.stuck import Overruled, Stuck

# Reasons, keys of the string tables.
PERSON, OBSTACLE, STANDS = "going_person", "going_obstacle", "going_stands"
# What the mission must do.
END_LEG, PLAN, GIVE_UP = "end the leg here", "plan again", "give up"
_NEAR_PERSON_M = 2.6
_NO_TURN_S, _OTHER_WAY_S = 1.8, 1.5
_GO_ROUND_S, _SEEN_S = 2.8, 0.8
_SAYS_S = 1.0
# Beside things the board permits no turn to a chair that may still roll by its upper bound of the
# speed, which is 1.8 s after the last output at most. Until then nothing is refused for good.
_ROLLS_S = 2.0


@dataclass(frozen=True)
class Verdict:
    """What comes of one period."""

    stick: Stick
    """To request now."""
    act: str = ""
    """END_LEG, PLAN or GIVE_UP; "": go on."""
    reason: str | None = None
    """Why it waits or gives up; "": it has moved, and waits no more; None: as before."""


class Recovery:
    """Of one mission. Call `put_out` in each period.

    In those in which it may drive, call `step`, or `meanwhile` while a plan is awaited.
    """

    def __init__(
        self, costmap: Costmap, obstacles: ObstacleLayer, follower: Follower, rolled: Rolled
    ) -> None:
        self._costmap, self._obstacles = costmap, obstacles
        self._follower, self._rolled = follower, rolled
        self.requested = STOP
        """What was requested in the last period."""
        self.begin()

    def begin(self) -> None:
        """Begin on the way to another goal."""
        self._overruled = Overruled()
        self.forget()

    def forget(self) -> None:
        """Forget what was refused: the mission gives up for now."""
        self.refused = Refusals()
        self.moves()

    def moves(self) -> None:
        """Nothing has been requested in vain so far."""
        self._stuck = Stuck()
        self._awaits: Stuck | None = None

    def in_the_way(self, pose: Pose) -> str:
        """Reason to report: PERSON if somebody walks nearby, else OBSTACLE."""
        return PERSON if self._obstacles.walker_within(*pose[:2], _NEAR_PERSON_M) else OBSTACLE

    def round_after_s(self, pose: Pose) -> float:
        """How long something is in the way before another path is searched for."""
        return _GO_ROUND_S if self.in_the_way(pose) == PERSON else _SEEN_S

    def may_be_person(self, pose: Pose) -> bool:
        """Whether a possible person is ahead: waiting helps before nothing else."""
        return self._costmap.ahead.meets(self._costmap.standing_m, np.array([pose]))

    def put_out(self, stick: Stick) -> None:
        """What the board has put out since the last period."""
        self._overruled.count(self.requested, stick)

    def another_path(self) -> None:
        """Another path is driven from now on."""
        self._overruled.another_path()

    def meanwhile(
        self, pose: Pose, stick: Stick, put_out: Stick, waits: bool, now_s: float
    ) -> Verdict:
        """The same as `step` while a plan is awaited: nothing is given up before it is there."""
        stuck = self._awaits or copy(self._stuck)
        stuck, moved = self._counted(stuck, stick, put_out, waits, now_s)
        self._awaits = stuck
        asks = self._rolls or self._overruled.asks_meanwhile(now_s)
        reason = self._reason(stuck, stuck.for_s(now_s), pose, moved)
        return Verdict(stick if asks else STOP, reason=reason)

    @property
    def _rolls(self) -> bool:
        """Whether a turn is refused only because the chair may still roll."""
        return self._follower.turns_on_spot and self._follower.undriven_s < _ROLLS_S

    def step(
        self, planner: Planner, pose: Pose, stick: Stick, put_out: Stick, waits: bool, now_s: float
    ) -> Verdict:
        """What to request, who wants `stick`; `waits`: before something that is in the way."""
        self._awaits = None
        self._stuck, moved = self._counted(self._stuck, stick, put_out, waits, now_s)
        if stick == STOP and not waits:
            return self._idles(moved)
        for_s = self._stuck.for_s(now_s)
        ask = stick if self._overruled.asks(0.0 if self._rolls else for_s, now_s) else STOP
        reason = self._reason(self._stuck, for_s, pose, moved)
        if not for_s:
            return Verdict(ask, reason=reason)
        early_rad = None if self._stuck.turns or waits else self._follower.early_turn_rad(pose)
        if early_rad is not None and planner.turns_freely(pose, early_rad):
            return Verdict(STOP, END_LEG, moved)
        if self._rolls:
            return Verdict(ask, reason=reason)
        return self._refused(pose, ask, for_s, reason)

    def _counted(
        self, stuck: Stuck, stick: Stick, put_out: Stick, waits: bool, now_s: float
    ) -> tuple[Stuck, str | None]:
        """What was in vain up to now, with the last period; "": the chair has moved."""
        turns, moved = self._follower.turns_on_spot, None
        if stuck.elsewhere(self._rolled.pose):
            moved, stuck = "", Stuck(self._rolled.pose, turns)
        stuck.count(self.requested != STOP or waits, put_out, now_s)
        if turns != stuck.turns and (stick != STOP or waits):
            stuck = Stuck(self._rolled.pose, turns)
        return stuck, moved

    def _reason(self, stuck: Stuck, for_s: float, pose: Pose, moved: str | None) -> str | None:
        """Reason to report after `for_s` in vain."""
        if stuck.let_out:
            return STANDS
        return self.in_the_way(pose) if for_s > _SAYS_S else moved

    def _idles(self, moved: str | None) -> Verdict:
        """A path requests nothing."""
        if not self._stuck.idles():
            return Verdict(STOP, reason=moved)
        looked, self._stuck.looked = self._stuck.looked, True
        return Verdict(STOP, GIVE_UP if looked else PLAN, STANDS)

    def _refused(self, pose: Pose, ask: Stick, for_s: float, reason: str | None) -> Verdict:
        """After `for_s` in vain."""
        stuck, turns = self._stuck, self._stuck.turns
        if for_s > (_NO_TURN_S if turns else _OTHER_WAY_S) and not stuck.looked:
            stuck.looked = True
            self._refuse(pose, turns, shut=turns)
            return Verdict(ask, PLAN, reason)
        if for_s > (PATIENCE_S if not turns and self.may_be_person(pose) else _GO_ROUND_S):
            if self.refused.shut_before(pose, turns):
                return Verdict(STOP, GIVE_UP, STANDS if stuck.let_out else NO_WAY)
            self._refuse(pose, turns, shut=True)
            self._stuck = Stuck(self._rolled.pose, turns, looked=True)
            return Verdict(ask, PLAN, reason)
        return Verdict(ask, reason=reason)

    def _refuse(self, pose: Pose, turns: bool, shut: bool) -> None:
        """Record that the board refuses this pose."""
        person = not turns and not shut and self.may_be_person(pose)
        self.refused.add(pose, turns, shut, person)
