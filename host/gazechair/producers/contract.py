"""The contract with a kind of producer: what it is given, and what it says in each step. Pure.

A kind is one class, named in kinds.py. It runs in a child process of its own and is asked every
50 ms while its mode is pressed. It has no clock, no thread and no pipe: child.py has those.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gazechair.base.footprint import Footprint
from gazechair.picture.newest import Shot
from gazechair.sensing.mapping.whereabouts import Whereabouts
from gazechair.sensing.odometry.odometry import Estimate, Motion
from gazechair.sensing.odometry.points import Piece

STEP_S = 0.05
"""From one step to the next."""


@dataclass(frozen=True)
class Setup:
    """What does not change while the process lives."""

    footprint: Footprint
    maps: Path
    """The folder of the stored maps."""
    state: Path = Path()
    """The folder of what survives a restart, as the camera's calibration."""
    thinker: Executor = field(default_factory=lambda: ThreadPoolExecutor(1))
    """For what takes longer than a step."""


@dataclass(frozen=True)
class Press:
    """What its person pressed."""

    number: int
    target: Mapping[str, Any]
    """As the daemon's Targets gave it."""
    settings: Mapping[str, int]
    """The board's, by name: those that ChairNumbers asks for."""
    may_reverse: bool
    """Lidars see behind the chair."""
    at_s: float


@dataclass(frozen=True)
class Ask:
    """A spot of the picture that somebody chose. Nothing drives before a press."""

    number: int
    at: tuple[float, float]
    """Shares of the picture's width, from its left, and height, from its top."""
    settings: Mapping[str, int]
    """As those of a press."""
    may_reverse: bool
    """As that of a press."""
    at_s: float


@dataclass
class Sensed:
    """What has come since the step before, each in the order of its times."""

    pieces: list[Piece] = field(default_factory=list)
    estimates: list[Estimate] = field(default_factory=list)
    motions: list[Motion] = field(default_factory=list)
    where: Whereabouts | None = None
    """The newest pose in a map; None: no newer one."""
    picture: Shot | None = None
    """The camera's newest; None: no newer one."""


@dataclass(frozen=True)
class Said:
    """What a producer says in a step."""

    stick: tuple[int, int] | None
    """Permille, forward and left positive; None: this press is over."""
    state: str = ""
    """For the pages: "thinks", "drives", "waits", "blocked", "arrived" or "ended"; of a
    spot that was chosen "thinks", "ready" (it may be pressed) or "ended"."""
    reason: str = ""
    """Why it waits, is blocked or has ended: a key of the string tables."""
    shown: Mapping[str, Any] = field(default_factory=dict)
    """More for the pages, small: see docs/going.md."""


class Producer(ABC):
    """One kind. What it raises ends its process, which is started again."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup

    @abstractmethod
    def press(self, press: Press) -> None:
        """Its mode was pressed anew: begin. What was before is over."""

    @abstractmethod
    def step(self, sensed: Sensed, now_s: float) -> Said:
        """Every 50 ms while it is pressed. While one takes longer, the chair stands."""


class SpotProducer(Producer):
    """One kind whose person first chooses a spot of the picture. It is pressed once that is ready.

    The target of a press says the number of the ask that it is for.
    """

    @abstractmethod
    def ask(self, ask: Ask) -> None:
        """A spot was chosen. What was chosen before is forgotten."""

    @abstractmethod
    def wait(self, sensed: Sensed, now_s: float) -> Said:
        """Every 50 ms while nobody presses. The chair is other people's business meanwhile."""
