"""A chair to tune; public attributes set what goes wrong, and when."""

from __future__ import annotations

import functools

from gazechair.commissioning.tune.armed_session import Hands
from gazelink import codes
from gazesim.chair import Chair
from gazesim.chair_rig import LinkedChair
from gazesim.profiles import undisturbed
from keptchair import KeptChair

_BOTH_TURNS = 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT


class TuneRig(LinkedChair):
    """Ready to arm; `wait` lets time pass, as Runner asks. Made by `tune_rig`."""

    def __init__(self, profile: str) -> None:
        super().__init__()
        self.world.chair = Chair(profile, 1, undisturbed(profile))
        self.world.chair.place(*self.world.room.start)
        self.start_deg = self.world.chair.heading_deg
        self.dies_at_ms = self.blocked_at_ms = 1 << 30
        self.strikes: tuple[int, str] = (1 << 30, "")  # a fault, by its name
        self.moved_after_death_ms = 0
        self.farthest_deg = 0.0
        self.until(self._ready, 6000)

    def _ready(self) -> bool:
        state = self.link.state()
        return state is not None and state.arm_reason == codes.NO_REASON

    def hands(self, abort_at_ms: int) -> Hands:
        """Somebody presses a key at that time."""
        return Hands(
            self.link, self.now_s, self.wait, lambda: self.now_ms >= abort_at_ms, lambda line: None
        )

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.run(max(1, round(seconds * 1000)))

    def one_ms(self) -> None:
        """Run everything for one millisecond."""
        super().one_ms()
        now_ms = self.now_ms
        self.link.alive = now_ms < self.dies_at_ms
        self.blocked = _BOTH_TURNS if now_ms >= self.blocked_at_ms else 0
        if not self.link.alive and not self.neutral():
            self.moved_after_death_ms = now_ms - self.dies_at_ms
        if now_ms == self.strikes[0]:
            self.world.faults.inject(self.strikes[1])
        turned = self.world.chair.heading_deg - self.start_deg
        self.farthest_deg = max(self.farthest_deg, abs(turned))


def tune_rig(profile: str = "3.1") -> TuneRig:
    """A chair of its own with that profile, ready to arm."""
    return _ready(profile).copy()


@functools.cache
def _ready(profile: str) -> KeptChair[TuneRig]:
    return KeptChair(TuneRig(profile))
