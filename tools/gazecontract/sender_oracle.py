"""The fuzzer's oracle: from the messages and their times, which motions the host may command.

Written from the promises (P3, P13, P14, docs/extending.md), not from the code: it sees messages,
and the commands that leave the host. Times are seconds of the fuzzer's clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from gazechair.board.board_commands import Command
from gazelink import codes

PROVEN_S = 0.3  # promise P3
MODE_S = 0.25
FRESH_S = 0.25
_CLOCK_S = 0.003  # tokens count whole milliseconds
_LOOK_S = 0.03

Motion = tuple[int, int, int, int]  # verb, mode, linear, turn
PressKey = tuple[str, int, int]  # who, their run, their press


class Violation(AssertionError):
    """Raised for a command that no message permits."""


@dataclass
class _Claim:
    motion: Motion | None  # None: on a mode
    mode: str
    birth_s: float


@dataclass
class _Press:
    role: int
    claims: list[_Claim] = field(default_factory=list)


@dataclass
class _Steer:
    birth_s: float
    number: int
    out: tuple[int, int]


class Oracle:
    """Sees every message before it is delivered; judges each command afterwards."""

    def __init__(self) -> None:
        self.armed = False
        self.connected = True
        self.owner = codes.NOBODY
        self._presses: dict[PressKey, _Press] = {}
        self._dead: set[PressKey] = set()
        self._bound: dict[int, PressKey] = {}  # the board's number of a press
        self._steers: dict[str, list[_Steer]] = {}
        self._page_s: dict[int, float] = {}
        self.judged = 0
        """Commands that were in force when judged."""

    # -- messages --

    @staticmethod
    def fresh(birth_s: float, now_s: float) -> bool:
        """True if a message born then counts at all."""
        return now_s - FRESH_S - _CLOCK_S <= birth_s <= now_s + _CLOCK_S

    def page_lives(self, role: int, now_s: float) -> None:
        """A page of that role sends something fresh."""
        self._page_s[role] = now_s

    def wants(
        self, key: PressKey, role: int, motion: Motion | None, mode: str, birth_s: float
    ) -> None:
        """Somebody presses, or still does."""
        new = key not in self._presses
        press = self._presses.setdefault(key, _Press(role))
        if new and not (self.armed and self.connected and role == self.owner):
            self._dead.add(key)
        press.claims = [*press.claims[-20:], _Claim(motion, mode, birth_s)]

    def never(self, key: PressKey) -> None:
        """This press must move nothing: it was over before it began."""
        self._dead.add(key)

    def lets_go(self, who: str) -> None:
        """The person of `who` let go. A step ends by itself."""
        for key, press in self._presses.items():
            motion = press.claims[-1].motion
            if key[0] == who and not (motion and motion[1] == codes.STEP):
                self._dead.add(key)

    def ends_of(self, who: str) -> None:
        """All presses of `who` are over."""
        self._dead |= {key for key in self._presses if key[0] == who}

    def stops(self) -> None:
        """Somebody permitted stops, takes over, arms or disarms; or the board was replaced."""
        self._dead |= self._presses.keys()

    def steers(self, mode: str, number: int, out: tuple[int, int], birth_s: float) -> None:
        """A mode sends its output."""
        kept = self._steers.setdefault(mode, [])
        self._steers[mode] = [*kept[-20:], _Steer(birth_s, number, out)]

    def mode_ends(self, mode: str) -> None:
        """A mode is gone, or has ended its press."""
        self._steers[mode] = []
        for key, press in self._presses.items():
            if press.claims[-1].mode == mode:
                self._dead.add(key)

    # -- commands --

    def judge(self, command: Command, now_s: float) -> None:
        """Raise Violation for a motion in force that is not permitted."""
        self._expire(now_s)
        if command.verb == codes.STOP or command.ttl_deadline_s <= now_s:
            return
        self.judged += 1
        if not (self.armed and self.connected):
            raise Violation("a motion while driving is off")
        if command.owner != self.owner:
            raise Violation(f"a motion of {command.owner}, and {self.owner} drives")
        if now_s - self._page_s.get(self.owner, -9.0) > PROVEN_S + _LOOK_S:
            raise Violation("a motion while the page of who drives is silent")
        fitting = [key for key in self._presses if self._permits(key, command)]
        bound = self._bound.get(command.edge)
        if bound in fitting:
            return
        if not fitting:
            raise Violation(f"nobody alive wants {command}")
        if bound is not None and bound not in self._dead:
            raise Violation(f"one number for two presses: {bound}, {fitting}")
        self._bound[command.edge] = fitting[-1]
        # The newest press counts and ends the others.
        self._dead |= self._presses.keys() - set(fitting)

    def _permits(self, key: PressKey, command: Command) -> bool:
        if key in self._dead:
            return False
        press = self._presses[key]
        motion = (command.verb, command.mode, command.linear_permille, command.turn_permille)
        until_s = command.ttl_deadline_s - _CLOCK_S
        newest = press.claims[-1]
        proven_s = max(claim.birth_s for claim in press.claims)
        if until_s > proven_s + PROVEN_S or press.role != command.owner:
            return False
        if newest.motion is not None:
            return newest.motion == motion
        out = (command.linear_permille, command.turn_permille)
        if command.verb != codes.DRIVE:
            return False
        return any(
            steer.out == out and until_s <= steer.birth_s + MODE_S
            for steer in self._steers.get(newest.mode, ())
        )

    def _expire(self, now_s: float) -> None:
        for key in list(self._presses):
            if now_s - max(c.birth_s for c in self._presses[key].claims) > PROVEN_S + _LOOK_S:
                self._dead.add(key)
        # Forget dead, old presses; their keys are never used again.
        if len(self._presses) > 200:
            for key in [key for key in self._presses if key in self._dead][:100]:
                del self._presses[key]
                self._dead.discard(key)
