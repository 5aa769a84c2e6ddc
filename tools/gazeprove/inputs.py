"""What may happen in one tick: chosen when the core looks, so that what it skips costs nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gazeboard.core import limits
from gazelink import codes

# What can go wrong, one by one. The others stay well in a scope that does not name them.
CAUSES = (
    "host",
    "service",
    "lidar",
    "source",
    "imu",
    "heading",
    "tilt",
    "calibration",
    "late",
    "emergency",
    "button",
    "relay",
    "wiper",
    "often",
    "obeys",
    "exception",
    "stop",
    "session",
    "auto",
)
_FEW_VERBS = (codes.STOP, codes.FORWARD, codes.LEFT)
_ALL_VERBS = (*range(len(codes.VERBS)), len(codes.VERBS))  # and one that does not exist


# Inputs whose values depend on more than the scope; what the others may be is kept for each scope.
_EACH_TIME = (
    "mode",
    "edge",
    "stop_edge",
    "clearance_blocked",
    "clearance_unseen",
    "supervision_edge",
)


@dataclass(frozen=True)
class Scope:
    """One exploration: which causes may strike, in any combination, at any time."""

    name: str
    causes: frozenset[str] = frozenset()
    all_commands: bool = False
    relay_fitted: bool = True
    simulated: bool = False
    boot_faults: int = 0
    never_drives: bool = False  # what boot found stands for good: no way to driving may exist


class Choices:
    """Walks a tree of choices leaf by leaf: pick() answers, following() goes to the next leaf."""

    def __init__(self) -> None:
        self._path: list[int] = []
        self._sizes: list[int] = []
        self._at = 0

    def pick(self, size: int) -> int:
        """A number below `size`."""
        at = self._at
        self._at = at + 1
        if at < len(self._path):
            return self._path[at]
        self._path.append(0)
        self._sizes.append(size)
        return 0

    def following(self) -> bool:
        """Prepare the next leaf. False when all were visited; then it begins anew."""
        path, sizes = self._path, self._sizes
        while path and path[-1] + 1 == sizes[-1]:
            path.pop()
            sizes.pop()
        self._at = 0
        if not path:
            return False
        path[-1] += 1
        return True


class Blocked:
    """Blocked bits, each chosen when the core asks for it."""

    def __init__(self, choices: Choices) -> None:
        self._choices = choices
        self.known: dict[int, int] = {}

    def __and__(self, mask: int) -> Any:
        if mask == 15:
            return self
        lowest = mask & -mask
        if lowest != mask:
            return (self & lowest) | (self & (mask - lowest))
        if mask not in self.known:
            self.known[mask] = mask * self._choices.pick(2)
        return self.known[mask]


class LazyInputs:
    """An Inputs whose fields but the counters are chosen when they are read, and then in `read`."""

    host_count: int
    service_count: int
    clearance_count: int
    heading_count: int
    command_count: int
    session_count: int
    stop_count: int
    emergency_count: int
    disarm_count: int
    arm_count: int
    reset_count: int
    press_count: int
    supervision_count: int

    def __init__(self, scope: Scope, choices: Choices) -> None:
        self._scope = scope
        self._choices = choices
        self._known: dict[str, tuple[Any, ...]] = {}  # what an input may be in this scope
        self.presses: tuple[int, ...] = ()  # that may come in a tick
        self.read: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        read = self.read
        if name in read:
            return read[name]
        values = self._known.get(name)
        if values is None:
            values = self._values(name)
            if name not in _EACH_TIME:
                self._known[name] = values
        size = len(values)
        value = read[name] = values[self._choices.pick(size)] if size > 1 else values[0]
        return value

    def _values(self, name: str) -> tuple[Any, ...]:
        causes, full = self._scope.causes, self._scope.all_commands
        if name == "verb":
            if full:
                return _ALL_VERBS
            return (*_FEW_VERBS, codes.DRIVE) if "auto" in causes else _FEW_VERBS
        if name == "mode":
            if "auto" in causes and self.verb in (codes.FORWARD, codes.DRIVE):
                return (codes.CONTINUOUS, codes.AUTO)
            if not full:
                return (codes.CONTINUOUS if self.verb == codes.FORWARD else codes.STEP,)
            return (codes.STEP, codes.CONTINUOUS)
        if name == "edge":
            return self.presses
        if name == "owner":
            return (codes.NOBODY, codes.DRIVER, codes.CARETAKER) if full else (codes.DRIVER,)
        if name in ("linear_permille", "turn_permille"):
            return (-1000, 0, 1000)
        if name in ("clearance_blocked", "clearance_unseen"):
            return (Blocked(self._choices),)
        if name == "supervision_edge":
            return self.presses
        if name == "supervision_age_ms":
            return (0, limits.AGE_MAX_MS)
        if name == "clearance_source":
            return (codes.REAL, codes.SIMULATED) if "source" in causes else (codes.REAL,)
        if name == "clearance_age_ms":
            return (0, 248, 298) if "lidar" in causes else (0,)
        if name == "heading_faults":
            return (0, 1 << codes.HEADING_FROZEN) if "heading" in causes else (0,)
        if name == "tilted":
            return (False, True) if "tilt" in causes else (False,)
        if name == "service_faults":
            return (0, 1 << codes.TILT_UNKNOWN) if "tilt" in causes else (0,)
        if name == "calibrated":
            return (True, False) if "calibration" in causes else (True,)
        if name == "stop_edge":
            return self.presses
        if name == "arm_owner":
            return (codes.NOBODY, codes.DRIVER, codes.CARETAKER, 3) if full else (codes.DRIVER,)
        if name == "ttl_ms":
            return (0, 300)
        if name in ("heading_q4", "rate_q4"):
            return (0,)
        if name == "cap_permille":
            return (1000,)
        raise AttributeError(name)


class AnyTurn:
    """A turn controller that answers anything at all."""

    def __init__(self, choices: Choices) -> None:
        self._choices = choices
        self.arrived = False
        self.missed = False

    def start(self, setpoint_q4: int, count: int) -> None:
        """Where to does not matter here."""

    def follow(self, turn_permille: int) -> None:
        """Nor what was put out."""

    def keep(self, heading_q4: int) -> None:
        """Nor which heading is held."""

    def hold(self, heading_q4: int, rate_q4: int) -> int:
        """Nothing, or far too much either way."""
        return (0, 9999, -9999)[self._choices.pick(3)]

    def update(self, heading_q4: int, rate_q4: int, count: int) -> int:
        """Arrived, missed, far too much either way, or nothing."""
        answer = self._choices.pick(5)
        self.arrived = answer == 3
        self.missed = answer == 4
        return (0, 9999, -9999, 0, 0)[answer]
