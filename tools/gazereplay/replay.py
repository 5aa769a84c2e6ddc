"""Plays a trace through the real core and compares every decision with the recorded one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.safety import Safety
from gazeboard.core.shared import Inputs
from gazeboard.core.tick import Tick
from gazeboard.core.tick_clock import TickClock
from gazeboard.io.settings import Settings
from gazeboard.turning.turn import turn_controller
from gazechair.blackbox.reader import Line, LogFile
from gazelink import codes
from gazereplay import trace
from gazereplay.trace import Taken


class NoTrace(ValueError):
    """A log that cannot be replayed; one line why."""


@dataclass(frozen=True)
class Difference:
    """The first tick that decided otherwise."""

    life: int
    """Which start of the board in this file, from 1."""
    tick: int
    at_ns: int
    """Wall time."""
    recorded: dict[str, int]
    now: dict[str, int]

    def __str__(self) -> str:
        changed = [name for name in self.recorded if self.recorded[name] != self.now[name]]
        words = [
            f"{name} {_word(name, self.recorded[name])} -> {_word(name, self.now[name])}"
            for name in changed
        ]
        return f"tick {self.tick} of start {self.life}: " + ", ".join(words)


@dataclass
class Result:
    """What a replay found."""

    ticks: int = 0
    lives: int = 0
    decisions: int = 0
    """How many differed from the tick before: what was there to compare."""
    armed: int = 0
    """Ticks in which driving was on."""
    difference: Difference | None = None


class Core:
    """The board's core with its parts, as gazeboard.app has them."""

    def __init__(self, settings: str, simulated: bool, boot_faults: int) -> None:
        s: Any = Settings(settings)
        self._neutral: tuple[int, int] | None = None
        self.inputs = Inputs()
        self._obstacles = Obstacles(s)
        self._obedience = Obedience(s)
        safety = Safety(simulated, s.relay_fitted, boot_faults)
        self._tick = Tick(safety, None, self._obstacles, self._obedience, None, TickClock())
        self.apply(settings)

    def apply(self, settings: str) -> None:
        """Other settings, while disarmed."""
        s: Any = Settings(settings)
        safety = self._tick.safety
        if s.neutral() != self._neutral:
            self._neutral = s.neutral()
            safety.neutral_moved()
        self._obstacles.configure(s)
        self._obedience.configure(s)
        turn = turn_controller(s)
        self._tick.motion = Motion(s, turn)
        self._tick.profile_check = ProfileCheck(turn.model)
        safety.set_relay_fitted(s.relay_fitted)

    def take(self, taken: Taken) -> None:
        """From the next tick on, these inputs."""
        for name, value in zip(trace.TAKEN, taken.inputs, strict=True):
            setattr(self.inputs, name, value)
        self.inputs.clearance_arcs = bytearray(taken.arcs)

    def tick(self, taken: Taken) -> dict[str, int]:
        """One tick; what it decided."""
        i = self.inputs
        if taken.service_alive:
            i.service_count = (i.service_count + 1) & 0xFFFF
        elapsed_us, relay, emergency, button, verified, neutral = taken.around
        self._tick.decide(i, elapsed_us, bool(relay), bool(emergency), bool(button))
        before = self._tick.enable_level
        level = self._tick.written(bool(verified), bool(neutral))
        return dict(zip(trace.DECIDED, trace.decision(self._tick, level != before), strict=True))


class Player:
    """Takes the messages of a trace in order; stops at the first difference."""

    def __init__(self) -> None:
        self.result = Result()
        self._core: Core | None = None
        self._tick = 0
        self._taken: Taken | None = None
        self._decided: dict[str, int] = {}
        self._began_ns = 0

    def hear(self, line: Line) -> None:
        """The next message; play the ticks before it. One of INPUTS or DECISION opens a tick."""
        message = line.message
        if line.topic == trace.START:
            self._core = Core(message.settings, message.simulated, message.boot_faults)
            self._tick = 0
            self._taken = None
            self._began_ns = line.at_ns
            self.result.lives += 1
            return
        if self._core is None:
            raise NoTrace("its trace does not begin with the start of the board")
        # A tick is played when the first message of a later one, or of none, has come.
        self._play_until(message.tick)
        if line.topic == trace.SETTINGS:
            self._core.apply(message.settings)
        elif line.topic == trace.INPUTS:
            self._taken = Taken.of(message)
            self._core.take(self._taken)
        elif line.topic == trace.DECISION:
            # What an older version did not have is not compared.
            names = [name for name in trace.DECIDED if hasattr(message, name)]
            self._decided = {name: getattr(message, name) for name in names}
            self.result.decisions += 1
        elif line.topic == trace.ENDED:
            self._core = None

    def _play_until(self, tick: int) -> None:
        result, core = self.result, self._core
        assert core is not None
        while self._tick < tick and result.difference is None:
            if self._taken is None:
                raise NoTrace("the trace has no inputs of its first tick")
            now = core.tick(self._taken)
            if any(now[name] != value for name, value in self._decided.items()):
                at_ns = self._began_ns + self._tick * 10**6
                result.difference = Difference(result.lives, self._tick, at_ns, self._decided, now)
                return
            self._tick += 1
            result.ticks += 1
            result.armed += now["state"] == codes.ARMED


def of_trace(lines: Iterable[Line]) -> Iterator[Line]:
    """Only the messages of a trace."""
    return (line for line in lines if line.topic in trace.DEFINITIONS)


def replay(path: Path) -> Result:
    """Play the log at `path`. Raises NoTrace when it holds nothing to play."""
    player = Player()
    for line in of_trace(LogFile(path).lines()):
        player.hear(line)
        if player.result.difference is not None:
            break
    if not player.result.lives:
        raise NoTrace("it has no trace of the board's ticks; see docs/log.md, Replay")
    return player.result


def _word(name: str, value: int) -> Any:
    if name in ("override", "arm_reason", "first_fault"):
        return codes.reason_name(value)
    if name == "state":
        return codes.STATES[value]
    if name == "motion":
        return codes.MOTIONS[value]
    if name == "faults":
        return [row[1] for row in codes.FAULTS if value >> row[0] & 1]
    return value
