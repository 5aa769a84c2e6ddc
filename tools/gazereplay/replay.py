"""Replays a trace through the real core and compares every decision with the recorded one."""

from __future__ import annotations

from collections.abc import Container, Iterator
from pathlib import Path

from gazeboard.io.settings import Settings
from gazechair.base import json_text
from gazechair.blackbox.reader import Line, LogFile
from gazelink import codes
from gazereplay import trace
from gazereplay.board_trace import TOPICS, BoardPlayer, Layout
from gazereplay.core import Core
from gazereplay.result import Difference, NoTrace, Result
from gazereplay.trace import Taken


class Player:
    """Takes the messages of a trace in order; stops at the first difference."""

    def __init__(self) -> None:
        self.result = Result()
        self._core: Core | None = None
        self._tick = 0
        self._taken: Taken | None = None
        self._decided: dict[str, int] = {}
        self._began_ns = 0

    def take(self, line: Line) -> None:
        """Take the next message; play the ticks before it. INPUTS or DECISION opens a tick."""
        message = line.message
        if line.topic == trace.START:
            settings = Settings(message.settings)
            self._core = Core(settings, message.simulated, message.boot_faults)
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
            self._core.apply(Settings(message.settings))
        elif line.topic == trace.INPUTS:
            self._taken = Taken.of(message)
            self._core.take(trace.TAKEN, self._taken.inputs, self._taken.arcs)
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
            now = core.tick(self._taken.around, self._taken.service_alive)
            if any(now[name] != value for name, value in self._decided.items()):
                at_ns = self._began_ns + self._tick * 10**6
                result.difference = Difference(result.lives, self._tick, at_ns, self._decided, now)
                return
            self._tick += 1
            result.ticks += 1
            result.compared += bool(self._decided)
            result.armed += now["state"] == codes.ARMED


def of_trace(file: LogFile) -> Iterator[Line]:
    """The messages of a log for its replay: of a board in virtual time, or as a board sent them."""
    topics: Container[str] = TOPICS
    if any(line.topic == trace.START for line in file.lines()):
        topics = trace.DEFINITIONS
    return (line for line in file.lines() if line.topic in topics)


def kept_layout(path: Path) -> Layout | None:
    """The names that as_test stored with a drive; None for other logs."""
    try:
        names = json_text.parse(path.with_suffix(".json").read_text(encoding="utf-8"))
    except (OSError, ValueError):  # none, or another of that name: an exported log
        return None
    if isinstance(names, list):  # without the inputs' names, which were these
        names = {"snapshot": names, "inputs": Layout.ours().inputs}
    if not isinstance(names, dict) or set(names) != {"snapshot", "inputs"}:
        return None
    lists = all(isinstance(one, list) for one in names.values())
    strings = lists and all(isinstance(name, str) for one in names.values() for name in one)
    return Layout(**names) if strings else None


def replay(path: Path) -> Result:
    """Replay the log at `path`. Raises NoTrace when it has no trace, or none to compare with."""
    player: Player | BoardPlayer = BoardPlayer(kept_layout(path))
    file = LogFile(path)
    for line in of_trace(file):
        if line.topic in trace.DEFINITIONS and isinstance(player, BoardPlayer):
            player = Player()
        player.take(line)
        if player.result.difference is not None:
            break
    result = player.result
    result.ending = "" if result.difference is not None else file.ending()
    cut = f"; {result.ending}" if result.ending else ""
    if not result.lives:
        raise NoTrace(f"it has no trace of the board's ticks; see docs/log.md, Replay{cut}")
    if not result.compared and result.difference is None:
        raise NoTrace(f"its trace has no decision to compare with{cut}")
    return result
