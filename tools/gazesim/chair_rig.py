"""The whole chair in virtual time: firmware, USB line, devices, chair and room.

Time advances only in steps of one millisecond: no threads, no wall clock, equal traces every time.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gazeboard.boards import pins
from gazeboard.core.limits import WIPER_NEUTRAL
from gazechair.board.board_commands import STOP_COMMAND, Clearance, Command
from gazelink import codes
from gazesim.bank import Bank
from gazesim.lockstep import Steps
from gazesim.lockstep_link import LockstepLink
from gazesim.lockstep_teensy import Teensy
from gazesim.rooms import Room
from gazesim.usb_line import UsbLine
from gazesim.world import ONE, Mount, World

NEUTRAL = (WIPER_NEUTRAL, WIPER_NEUTRAL)
CLEARANCE_MS = 50  # between two clearances


class ChairRig(Steps):
    """The chair without a host. Times are milliseconds of the board's own ticks."""

    def __init__(
        self,
        room: str | Room = "open",
        profile: str = "3.1",
        seed: int = 1,
        start_us: int = 0,
        mounts: tuple[Mount, ...] = ONE,
    ) -> None:
        self.now_ms = 0
        self.bank = Bank.in_memory()
        self.world = World(self.bank, room, profile, seed, mounts=mounts)
        self.cable = UsbLine()
        self.board = Teensy(self.world, self.cable, start_us)
        self.scanned = b""  # what the lidar sent in the last step
        self.quiet_ms = 0
        """Milliseconds since the enable line was last toggled."""
        self._enable = self.bank.pin(pins.ENABLE)
        self._enable_count = 0

    def now_s(self) -> float:
        """The clock of every part of the simulation."""
        return self.now_ms / 1000

    @property
    def app(self) -> Any:
        """The firmware's App; None while the board is off, resetting or in its REPL."""
        return self.board.app

    def one_ms(self) -> None:
        """One step: the host, the board, then the world, which sees their outputs."""
        self.now_ms += 1
        self.cable.advance(self.now_ms)
        self.host_ms()
        self.cable.advance(self.now_ms)
        self.board.one_ms()
        self.scanned = self.world.step(0.001)
        count = self._enable.out_count
        self.quiet_ms = 0 if count != self._enable_count else self.quiet_ms + 1
        self._enable_count = count

    def host_ms(self) -> None:
        """One millisecond at the other end of the line; here nobody."""

    def wipers(self) -> tuple[int, int]:
        """The pot's registers: (linear, turn) counts."""
        return self.world.pot.poll()

    def neutral(self) -> bool:
        """True if both wipers are at the stored centre."""
        return self.wipers() == NEUTRAL

    def harmless(self) -> bool:
        """True if nothing reaches the chair: neutral wipers, or an open relay."""
        return self.neutral() or not self.world.relay.closed

    def stands(self) -> bool:
        """True if the chair does not move, by the simulator's truth."""
        return self.world.chair.speed_m_s == 0 and abs(self.world.chair.yaw_rate_deg_s) < 1e-9

    def armed(self) -> bool:
        """True if armed, by the board's own state."""
        return self.app is not None and self.app.safety.state == codes.ARMED

    def fault(self, bit: int) -> bool:
        """True if the board has set this fault bit."""
        return bool(self.app.safety.faults & (1 << bit))

    def enable_off(self) -> bool:
        """True if the enable line is low, floats, or was not toggled in this tick."""
        pin = self._enable
        return pin.latch == 0 or pin.mode != 1 or self.quiet_ms > 0

    def override(self) -> str:
        """Why the board overrules the present command."""
        return str(codes.reason_name(self.app.safety.override))

    def why(self) -> str:
        """The situation in one line, for failed assertions."""
        words = [f"{self.now_ms} ms wipers {self.wipers()} chair {self.world.chair.speed_m_s:.3f}"]
        if self.app is not None:
            s = self.app.safety
            words.append(f"state {codes.STATES[s.state]} override {self.override()}")
            names = [f[1] for f in codes.FAULTS if s.faults & (1 << f[0])]
            words.append(f"faults {names} arm_reason {codes.reason_name(s.arm_reason)}")
        return "; ".join(words)

    def comes_to_rest(self) -> None:
        """Run until the chair stands; asserts that no output reaches it meanwhile."""
        for _ in range(3000):
            self.one_ms()
            assert self.harmless(), self.why()
            if self.stands():
                return
        raise AssertionError(f"still moving: {self.why()}")


class LinkedChair(ChairRig):
    """A ChairRig with the host's link and an active press; faults are public attributes."""

    def __init__(self, room: str | Room = "open", profile: str = "3.1", seed: int = 1) -> None:
        super().__init__(room, profile, seed)
        self.link = LockstepLink(self.cable, self.now_s, iter(range(7, 9999)).__next__)
        self.holds = True  # False: no more proof that the press is active
        self.sees = True  # False: no more clearance, except what the link repeats
        self.blocked = 0
        self.owner = codes.CARETAKER
        self._command = STOP_COMMAND
        self._edge = 0

    def host_ms(self) -> None:
        """The link, the press, and a clearance now and then."""
        self.link.one_ms()
        now_s = self.now_s()
        if self.holds and self._command.verb != codes.STOP:
            self.link.command(replace(self._command, ttl_deadline_s=now_s + 0.3))
        if self.sees and self.now_ms % CLEARANCE_MS == 0:
            self.link.clearance(Clearance(self.blocked, codes.SIMULATED, now_s - 0.02))

    def press(
        self, verb: int, mode: int = codes.CONTINUOUS, turn_permille: int = 0, pulse_ms: int = 0
    ) -> None:
        """Begin a press and keep it active."""
        self._edge = self._edge % 255 + 1
        self._command = Command(
            verb, mode, self._edge, self.owner, 0.0, turn_permille=turn_permille, pulse_ms=pulse_ms
        )

    def release(self) -> None:
        """Release the button: send a stop."""
        self._command = STOP_COMMAND
        self.link.command(STOP_COMMAND)

    def arm(self) -> None:
        """Run until the board is armed by the owner."""

        def armed() -> bool:
            if self.app.safety.arm_reason == codes.NO_REASON and self.now_ms % 100 == 0:
                self.link.order(codes.ARM, self.owner)
            return self.armed()

        self.until(armed, 6000)
