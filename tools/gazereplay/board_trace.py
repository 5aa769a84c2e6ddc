"""Replays the trace that a board sent, and compares every reported state with the core's."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gazeboard.io import joystick, trace
from gazeboard.io.settings import Settings
from gazechair.blackbox.reader import Line
from gazelink import VERSION, arcs, codes, frame
from gazelink.settings_table import NAMES
from gazereplay.core import Core, layouts, without_casters
from gazereplay.result import Difference, NoTrace, Result
from gazereplay.stream import Inputs, Record, Silent, Snapshot, Stream
from gazereplay.trace import DECIDED, filled

HELLO, STATE, TRACE = "/board/hello", "/board/state", "/board/trace"
TOPICS = (HELLO, STATE, TRACE)
_WAITING_NS = 20 * 10**9  # a state's 16 bits of the tick are unambiguous for longer


class _Pace:
    """Replaces TickClock: a trace has its results, not the microseconds."""

    owes = True

    def __init__(self) -> None:
        self.late = False
        self.missed_ms = 0

    def step(self, _elapsed_us: int) -> int:
        """The milliseconds that passed without a tick."""
        return self.missed_ms


@dataclass(frozen=True)
class Layout:
    """The names of the words in a board's trace."""

    snapshot: Sequence[str]
    """Of a chair whose casters turn it further."""
    inputs: Sequence[str]

    @classmethod
    def ours(cls) -> Layout:
        """Of this version's firmware."""
        ways = (f"arcs {k}/{arcs.SIZE}" for k in range(arcs.SIZE))
        return cls(layouts()[0], [*trace.FIELDS, *ways])


class BoardPlayer:
    """Takes the messages of a log in order; stops at the first difference."""

    def __init__(self, kept: Layout | None = None) -> None:
        """`kept`: the layout that is known to be this log's; None: the one of its version."""
        self._kept = kept is not None
        self._ours = Layout.ours()
        self._layout = kept or self._ours
        self.result = Result()
        self._stream = self._new_stream()
        self._life: tuple[int, int] | None = None  # boot, session
        self._version: tuple[tuple[int, ...], int] | None = None  # and hash of its table
        self._boots: list[int | None] = []
        self._core: Core | None = None
        self._pace = _Pace()
        self._tick = 0  # the newest played
        self._around = 0
        self._silent: deque[Silent] = deque()
        self._states: deque[tuple[int, Any]] = deque()
        self._last: dict[str, int] = {}

    def take(self, line: Line) -> None:
        """Take the next message; play the ticks whose inputs are now known."""
        message = line.message
        if line.topic == STATE:
            self._states.append((line.at_ns, message))
            while line.at_ns - self._states[0][0] > _WAITING_NS:
                self._states.popleft()
        elif line.topic == HELLO:
            life = (message.boot, message.session)
            if message.role == codes.ROLE_BOARD and life != self._life:
                self._life = life
                self._version = (message.major, message.minor, message.patch), message.schema_hash
                self._stream = self._new_stream()
                self._states.clear()
        elif line.topic == TRACE:
            for record in self._stream.frame(message.part, message.begins, bytes(message.data)):
                self._take(record)
                if self.result.difference is not None:
                    return

    def _new_stream(self) -> Stream:
        return Stream(len(self._layout.inputs))

    def _take(self, record: Record) -> None:
        if isinstance(record, Snapshot):
            self._snapshot(record)
            return
        if isinstance(record, Silent):
            self._silent.append(record)
            return
        assert self._core is not None
        if isinstance(record, Inputs):
            self._play_before(record.tick)
            names = self._ours.inputs
            found = filled(dict(zip(self._layout.inputs, record.words, strict=True)), names)
            values = [found[name] for name in names]
            count = len(trace.FIELDS)
            self._core.take(trace.FIELDS, values[:count], values[count:])
        else:
            self._play_before(record.tick - _missed_ms(record.bits))
            self._around = record.bits

    def _snapshot(self, snapshot: Snapshot) -> None:
        if not snapshot.lost and snapshot.tick >= self._tick:  # the count of ticks has a wrap
            self._play_before(snapshot.tick + 1)
            return
        boot = self._life[0] if self._life else None
        if not self._kept:
            self._check_version()
        if not self._boots or self._boots[-1] != boot:
            self._boots.append(boot)
            self.result.lives += 1
        elif self._core is not None:
            self.result.unchecked += max(0, snapshot.tick - self._tick)
            self.result.gaps += 1
        self._pace = _Pace()
        self._core = _core(snapshot.words, self._layout.snapshot, self._pace)
        self._around = snapshot.around
        self._tick = snapshot.tick
        self._silent.clear()

    def _check_version(self) -> None:
        """Raise NoTrace for a board whose snapshots would be read by the wrong names."""
        if self._version is None:
            self.result.unnamed = True
            return
        (its_version, its_table), (version, table) = self._version, _ours()
        if (its_version, its_table) != (version, table):
            other = ", with another table" if its_table != table else ""
            raise NoTrace(
                "its board had another version of the firmware"
                f" ({_words(its_version)}, here {_words(version)}{other})"
            )

    def _play_before(self, end: int) -> None:
        """Play the ticks before `end`; each also counts those missed before it."""
        core, result, bits = self._core, self.result, self._around
        assert core is not None
        self._pace.missed_ms = _missed_ms(bits)
        self._pace.late = bool(bits >> 4 & 1)
        around = (0, *(bits >> bit & 1 for bit in range(4)))
        while result.difference is None:
            tick = self._tick + 1 + self._pace.missed_ms
            if tick >= end:
                return
            now = core.tick(around, self._alive(tick))
            self._tick = tick
            result.ticks += 1
            result.armed += now["state"] == codes.ARMED
            result.decisions += now != self._last
            self._last = now
            self._compare(now)

    def _alive(self, tick: int) -> bool:
        """True if this tick sees a sign of life of the service loop."""
        silent = self._silent
        while silent and silent[0].until < tick:
            silent.popleft()
        return not silent or self._tick <= silent[0].tick

    def _compare(self, now: dict[str, int]) -> None:
        states = self._states
        while states and (behind := _signed(states[0][1].board_ms - self._tick)) <= 0:
            at_ns, state = states.popleft()
            if behind < 0:
                continue
            recorded = _state_fields(state)
            # What an older version did not report is not compared.
            ours = {name: value for name, value in self._tell(now).items() if name in recorded}
            self.result.compared += 1
            if recorded != ours:
                self.result.difference = Difference(
                    self.result.lives, self._tick, at_ns, recorded, ours
                )
                return

    def _tell(self, now: dict[str, int]) -> dict[str, int]:
        """A tick's decisions in the form of STATE."""
        assert self._core is not None
        fields = {name: now[name] for name in _NAMES}
        if now["faults"] >> codes.OBSTACLE_DATA_OLD & 1:
            fields["decisions"] = 0xFF
        stick = self._core.stick
        fields["linear_permille"] = joystick.permille(stick.linear_wiper, stick.neutral_linear)
        fields["turn_permille"] = joystick.permille(stick.turn_wiper, stick.neutral_turn)
        return fields


_NAMES = tuple(name for name in DECIDED if name != "toggled")  # not in a STATE


def _core(words: Sequence[int], layout: Sequence[str], pace: _Pace) -> Core:
    """The core in the snapshot's state; raises NoTrace."""
    settings = Settings()
    if len(layout) != len(words):
        layout = without_casters(layout)
    if len(layout) != len(words):
        raise NoTrace("its board had another version of the firmware, with another core")
    named = dict(zip(layout, words, strict=True))
    for name in NAMES:
        setattr(settings, name, named.get(name, getattr(settings, name)))
    core = Core(settings, simulated=False, boot_faults=0, clock=pace)
    core.restore(named)
    return core


def _ours() -> tuple[tuple[int, ...], int]:
    return VERSION, frame.schema_hash()


def _words(version: Sequence[int]) -> str:
    return ".".join(map(str, version))


def _state_fields(state: Any) -> dict[str, int]:
    fields = {"state": state.status & 15, "motion": state.status >> 4}
    return fields | {name: getattr(state, name) for name in _NAMES[2:] if hasattr(state, name)}


def _missed_ms(bits: int) -> int:
    return bits >> 5


def _signed(number: int) -> int:
    return (number + 0x8000 & 0xFFFF) - 0x8000
