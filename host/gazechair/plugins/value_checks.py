"""Checks a plug-in's values, and passes them to Control. Pure: time is passed with each call.

A value counts only while it is fresh, in order and not from the future; nothing is queued.
A value that no correct plug-in sends raises BadValue, which ends its process and its motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from gazechair.base.latest_value import Clock
from gazechair.driving.messages import LET_GO, STOP, VERBS, Beat, Drive, PageMessage, UseMode
from gazechair.driving.mode_context import ModeOutput
from gazechair.driving.refusal import Refusal
from gazechair.driving.tokens import VALID_S
from gazechair.plugins.contract import Intent
from gazechair.plugins.exchange import AUTO_LIFE_S, LIFE_S, BadValue, Value, unpack
from gazelink import codes

_AHEAD_S = 0.002  # all processes share one clock: a later time is forged
_REST_S = 0.3  # as on the driver's page: a worn stick that flickers does not undo a stop
_LATE_S = 1.0  # only old values for this long are a fault


class Port(Protocol):
    """What this needs from Control."""

    def join(self, role: str) -> int: ...
    def disconnect(self, client: int) -> None: ...
    def proof(self, born_s: float) -> int: ...
    def stopped_s(self) -> float: ...
    def act(self, client: int, meaning: PageMessage) -> Refusal | None: ...
    def mode_output(
        self, mode: str, number: int, output: ModeOutput, till_s: float, reached: bool = True
    ) -> None: ...


class _Times:
    """Decides which values count, by their birth times."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._newest_s = 0.0
        self._late_since_s: float | None = None

    def fresh(self, born_s: float) -> bool:
        """True if a value born then counts. Raises BadValue for an impossible time."""
        now_s = self._clock()
        if born_s > now_s + _AHEAD_S:
            raise BadValue(f"a value from {born_s - now_s:.3g} s in the future")
        if born_s < self._newest_s:
            return False
        self._newest_s = born_s
        if now_s - born_s <= VALID_S:
            self._late_since_s = None
            return True
        if self._late_since_s is None:
            self._late_since_s = now_s
        if now_s - self._late_since_s > _LATE_S:
            raise BadValue(f"only values that are {now_s - born_s:.3g} s old")
        return False


class InputRun:
    """One run of an input's process: a client of the arbiter, alongside its person's page."""

    def __init__(self, port: Port, person: str, clock: Clock) -> None:
        self._port = port
        self._times = _Times(clock)
        self._client = port.join(person)
        self._stops = 0
        self._newest = Intent("stop")
        # Nothing moves until the person has let go for a moment: neither what was held at the
        # start, nor what was held through anyone's stop.
        self._began_s = clock()
        self._nothing_since_s: float | None = None
        self._rested_s = 0.0  # when it had last rested long enough
        self.refused = ""
        """Why the newest press does not move the chair, a key of the string tables."""

    def take(self, payload: bytes) -> Value:
        """Act on a value; raises BadValue."""
        value = unpack(payload)
        if not self._times.fresh(value.born_s):
            return value
        was, self._newest = self._newest, value.intent
        proof = self._port.proof(value.born_s)
        self._port.act(self._client, Beat(proof))
        if value.stops != self._stops or value.intent.do == "stop":
            self._stops = value.stops
            self._port.act(self._client, STOP)
        if value.intent.do == "nothing":
            self._rest(value.born_s)
            if was.do not in ("nothing", "step"):
                self._port.act(self._client, LET_GO)
            return value
        self._nothing_since_s = None
        if value.intent.moves and self._rested_s > max(self._began_s, self._port.stopped_s()):
            refusal = self._port.act(self._client, _meaning(value, proof))
            self.refused = "" if refusal is None else refusal.reason
        return value

    def _rest(self, now_s: float) -> None:
        if self._nothing_since_s is None:
            self._nothing_since_s = now_s
        since_s = max(self._nothing_since_s, self._began_s, self._port.stopped_s())
        if now_s - since_s >= _REST_S:
            self._rested_s = now_s

    def end(self) -> None:
        """Its process has ended, or is about to end: end its press."""
        self._port.disconnect(self._client)


class ModeRun:
    """One run of a mode's process."""

    def __init__(
        self,
        port: Port,
        name: str,
        clock: Clock,
        auto: bool = False,
        within: Callable[[int, int], tuple[int, int]] = lambda linear, turn: (linear, turn),
    ) -> None:
        """`within`: the output to request for a value's, linear and turn in permille."""
        self._port = port
        self._name = name
        self._within = within
        self._life_s = AUTO_LIFE_S if auto else LIFE_S
        self._clock = clock
        self._times = _Times(clock)

    def take(self, payload: bytes, reached: bool = True) -> Value:
        """Act on a value; raises BadValue. `reached`: an end in this value is at its goal."""
        value = unpack(payload)
        if value.intent.do not in ("nothing", "drive"):
            raise BadValue("an intent that is no mode's")
        if self._times.fresh(value.born_s) and value.press:
            i = value.intent
            moves = i.do == "drive"
            output = self._within(i.linear_permille, i.turn_permille) if moves else None
            till_s = value.born_s + self._life_s
            self._port.mode_output(self._name, value.press, output, till_s, reached)
        return value

    def lives(self, value: Value) -> bool:
        """True if the value is young enough to move the chair."""
        return self._clock() < value.born_s + self._life_s


def _meaning(value: Value, proof: int) -> Drive | UseMode:
    i, edge = value.intent, value.press + 1
    if i.do == "choose":
        return UseMode(i.what, edge, proof, LIFE_S)
    if i.do == "drive":
        out = (i.linear_permille, i.turn_permille)
        return Drive(codes.DRIVE, codes.CONTINUOUS, edge, proof, *out, LIFE_S)
    mode = codes.STEP if i.do == "step" else codes.CONTINUOUS
    return Drive(VERBS[i.what], mode, edge, proof, 0, 0, LIFE_S)
