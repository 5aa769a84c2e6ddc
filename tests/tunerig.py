"""A chair to tune: the real firmware, devices and twin in virtual time, and the link of a host."""

from __future__ import annotations

from e2e.lockstep import Lockstep
from gazechair.board.board_commands import Clearance
from gazelink import codes
from gazesim.chair import Chair
from gazesim.lockstep_link import LockstepLink
from gazesim.profiles import Parameters, undisturbed

_CLEARANCE_MS = 50
_BOTH_TURNS = 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT


class _Link(LockstepLink):
    """A link whose host may die."""

    dead = False

    def one_ms(self) -> None:
        if not self.dead:
            super().one_ms()

    def _flush(self) -> None:
        if not self.dead:
            super()._flush()


class TuneRig:
    """`wait` lets time pass, as Runner asks. What is to go wrong, and when, is public."""

    def __init__(self, profile: str = "3.1", parameters: Parameters | None = None) -> None:
        self.lockstep = Lockstep()
        self.lockstep.kill_host()
        world = self.lockstep.world
        world.chair = Chair(profile, 1, parameters or undisturbed(profile))
        world.chair.place(*world.room.start)
        self.start_deg = world.chair.heading_deg
        self.link = _Link(self.lockstep.cable, self.now_s, iter(range(7, 99)).__next__)
        self.seeing = True
        self.dies_at_ms = self.blocked_at_ms = 1 << 30
        self.fault: tuple[int, str] = (1 << 30, "")
        self.moved_after_death_ms = 0
        self.farthest_deg = 0.0
        self.until_ready()

    def now_s(self) -> float:
        """The clock of everybody."""
        return self.lockstep.now_s()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(max(1, round(seconds * 1000))):
            self.one_ms()

    def one_ms(self) -> None:
        """A millisecond of everything."""
        self.lockstep.one_ms()
        now_ms = self.lockstep.now_ms
        self.link.one_ms()
        self.link.dead = now_ms >= self.dies_at_ms
        if self.link.dead and not self.lockstep.neutral():
            self.moved_after_death_ms = now_ms - self.dies_at_ms
        if now_ms == self.fault[0]:
            self.lockstep.world.faults.inject(self.fault[1])
        if self.seeing and now_ms % _CLEARANCE_MS == 0:
            blocked = _BOTH_TURNS if now_ms >= self.blocked_at_ms else 0
            self.link.clearance(Clearance(blocked, codes.SIMULATED, self.now_s() - 0.02))
        turned = self.lockstep.world.chair.heading_deg - self.start_deg
        self.farthest_deg = max(self.farthest_deg, abs(turned))

    def until_ready(self) -> None:
        """Nothing stands against arming."""

        def ready() -> bool:
            state = self.link.state()
            return state is not None and state.arm_reason == 0

        for _ in range(6000):
            if ready():
                return
            self.one_ms()
        raise AssertionError(self.lockstep.why())
