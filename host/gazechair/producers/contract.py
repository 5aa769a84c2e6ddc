"""The contract with a kind of producer: its inputs, and its output in each step. Pure.

A kind is one class, listed in kinds.py. It runs in its own child process and is called every
50 ms while its mode is pressed. It has no clock, thread or pipe: child.py has those.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from gazechair.base.footprint import Footprint
from gazechair.picture.newest import Shot
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.odometry.estimate import Estimate

STEP_S = 0.05
"""Period of the steps."""
CHANGED, UNCALIBRATED = "going_changed", "camera_uncalibrated"
"""Reasons, keys of the string tables: the target no longer exists; the camera's pose is unknown."""
MotionState = Literal["", "thinks", "drives", "waits", "blocked", "arrived", "ended", "ready"]
"""Of a motion, for the pages; of a spot that was chosen "thinks", "ready" (it may be pressed) or
"ended"; "": nothing to show."""
STATES: tuple[MotionState, ...] = get_args(MotionState)
KEPT_S = 60.0
"""How long a chosen spot lasts without a press."""


@dataclass(frozen=True)
class Setup:
    """Values that do not change while the process runs."""

    footprint: Footprint
    maps: Path
    """The folder of the stored maps."""
    state: Path = Path()
    """The folder for data that survives a restart, such as the camera's calibration."""
    thinker: Executor = field(default_factory=lambda: ThreadPoolExecutor(1))
    """For work that takes longer than a step."""


@dataclass(frozen=True)
class Press:
    """A press of its mode."""

    number: int
    target: Mapping[str, Any]
    """As the daemon's Targets gave it."""
    settings: Mapping[str, int]
    """The board's settings that ChairNumbers needs, by name."""
    may_reverse: bool
    """True if lidars see behind the chair."""
    at_s: float


@dataclass(frozen=True)
class Ask:
    """A spot in the picture that somebody chose. Nothing drives before a press."""

    number: int
    at: tuple[float, float]
    """Fractions of the picture's width, from its left, and height, from its top."""
    settings: Mapping[str, int]
    """As those of a press."""
    may_reverse: bool
    """As that of a press."""
    at_s: float


@dataclass
class Sensed:
    """Data since the previous step, each in order of time."""

    pieces: list[Piece] = field(default_factory=list)
    estimates: list[Estimate] = field(default_factory=list)
    motions: list[Motion] = field(default_factory=list)
    where: Whereabouts | None = None
    """The newest pose in a map; None: no newer one."""
    picture: Shot | None = None
    """The camera's newest; None: no newer one."""
    cap_permille: int = 1000
    """The speed cap now: the highest output of each axis."""


@dataclass(frozen=True)
class Output:
    """A producer's output in a step."""

    stick: tuple[int, int] | None
    """Output in permille, forward and left positive; None: this press is over."""
    state: MotionState = ""
    reason: str = ""
    """Why it waits, is blocked or has ended: a key of the string tables."""
    shown: Mapping[str, Any] = field(default_factory=dict)
    """More for the pages, small: see docs/going.md."""


class Producer(ABC):
    """One kind. An exception ends its process, which is restarted."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup

    @abstractmethod
    def press(self, press: Press) -> None:
        """A new press of its mode: begin. Everything before is over."""

    @abstractmethod
    def step(self, sensed: Sensed, now_s: float) -> Output:
        """Called every 50 ms while pressed. While a step takes longer, the chair stands."""


class SpotProducer(Producer):
    """One kind whose person first chooses a spot in the picture, and presses once that is ready.

    The target of a press has the number of its ask.
    """

    @abstractmethod
    def ask(self, ask: Ask) -> None:
        """A spot was chosen. It replaces any earlier one."""

    @abstractmethod
    def wait(self, sensed: Sensed, now_s: float) -> Output:
        """Called every 50 ms while its tile is not pressed; others may drive meanwhile."""
