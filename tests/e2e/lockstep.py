"""Everything in virtual time in one process: page, host, line, real firmware, chair, room, devices.

One millisecond a step, nothing else moves time: no threads, no wall clock, equal traces every time.
"""

from __future__ import annotations

from collections.abc import Callable

from e2e.host import Host
from e2e.page import Page
from gazeboard.boards import bank_layout as layout
from gazeboard.boards import pins
from gazelink import codes
from gazesim.bank import Bank
from gazesim.lockstep_teensy import Teensy
from gazesim.usb_line import UsbLine
from gazesim.world import World

NEUTRAL = (170, 170)
_ENABLE = pins.ENABLE


class Lockstep:
    """The whole chair; `page` is the driver's. Times are milliseconds of the board's own ticks."""

    def __init__(self, room: str = "open", start_us: int = 0) -> None:
        self.now_ms = 0
        self.bank = Bank.in_memory()
        self.world = World(self.bank, room)
        self.cable = UsbLine()
        self.board = Teensy(self.bank, self.cable, start_us)
        self.host: Host | None = Host(self.cable, self.world.lidar.receive, self.now_s)
        self.page = Page(self.host)
        self._scan = b""
        self._enable_count = 0
        self._frames = 0
        self.quiet_ms = 0
        """Since the enable line was last toggled."""
        self.unheard_ms = 0
        """Since the board last decoded a frame."""
        self.watchers: list[Callable[[], None]] = []

    def now_s(self) -> float:
        """The clock of everybody in this world."""
        return self.now_ms / 1000

    # -- time --

    def one_ms(self) -> None:
        """One step: the page, the host, the board, then the world, which sees what they did."""
        self.now_ms += 1
        self.cable.advance(self.now_ms)
        if self.host is not None:
            self.page.one_ms(self.now_ms)
            self.host.scan(self._scan)
            self.host.one_ms(self.now_ms)
            self.cable.advance(self.now_ms)
        self.board.one_ms()
        self._scan = self.world.step(0.001)
        self._observe()
        for watch in self.watchers:
            watch()

    def _observe(self) -> None:
        count = self.bank.pin(_ENABLE).out_count
        self.quiet_ms = 0 if count != self._enable_count else self.quiet_ms + 1
        self._enable_count = count
        frames = self.board.app.link._decoder.ok if self.board.app is not None else self._frames
        self.unheard_ms = 0 if frames != self._frames else self.unheard_ms + 1
        self._frames = frames

    def run(self, ms: int) -> None:
        """Let `ms` pass."""
        for _ in range(ms):
            self.one_ms()

    def until(self, condition: Callable[[], bool], limit_ms: int) -> int:
        """Milliseconds until `condition`; AssertionError when it takes longer than `limit_ms`."""
        for ms in range(limit_ms + 1):
            if condition():
                return ms
            self.one_ms()
        raise AssertionError(f"not within {limit_ms} ms: {self.why()}")

    # -- what is so --

    def wipers(self) -> tuple[int, int]:
        """The pot's registers: (linear, turn) counts."""
        return self.world.pot.poll()

    def neutral(self) -> bool:
        """Both wipers at the stored centre."""
        return self.wipers() == NEUTRAL

    def harmless(self) -> bool:
        """Nothing reaches the chair: neutral wipers, or an open relay."""
        return self.neutral() or not self.world.relay.closed

    def stands(self) -> bool:
        """The chair does not move: the truth, not what anyone says."""
        return self.world.chair.speed_m_s == 0 and abs(self.world.chair.yaw_rate_deg_s) < 1e-9

    def armed(self) -> bool:
        """By the board's own state."""
        return self.board.app is not None and self.board.app.safety.state == codes.ARMED

    def fault(self, bit: int) -> bool:
        """Whether the board has set this fault bit."""
        return bool(self.board.app.safety.faults & (1 << bit))

    def enable_off(self) -> bool:
        """The enable line is low or floats: it has not been toggled in this tick."""
        pin = self.bank.pin(_ENABLE)
        return pin.latch == 0 or pin.mode != 1 or self.quiet_ms > 0

    def override(self) -> str:
        """Why the board overrules the present command."""
        return str(codes.reason_name(self.board.app.safety.override))

    def connected(self) -> bool:
        """Host and board are in the same session."""
        if self.host is None or self.board.app is None or self.host.link.board() is None:
            return False
        return bool(self.board.app.link._session == self.host.link.board().session)

    def ticks(self) -> int:
        """The board's own count of ticks since its reset."""
        return self.bank.u32(layout.TICK_MS_AT)

    def why(self) -> str:
        """For messages of failed assertions."""
        app = self.board.app
        words = [f"{self.now_ms} ms wipers {self.wipers()} chair {self.world.chair.speed_m_s:.3f}"]
        if app is not None:
            s = app.safety
            words.append(f"state {codes.STATES[s.state]} override {self.override()}")
            names = [f[1] for f in codes.FAULTS if s.faults & (1 << f[0])]
            words.append(f"faults {names} arm_reason {codes.reason_name(s.arm_reason)}")
        if self.host is not None:
            words.append(f"refusals {self.host.refusals[-3:]}")
        return "; ".join(words)

    # -- what people do --

    def make_ready(self) -> None:
        """Wait until nothing stands against arming."""
        self.until(lambda: self.connected() and not self.armed(), 6000)
        self.until(lambda: self.page.shown.get("arm_reason") == "none", 6000)

    def arm(self) -> None:
        """Armed by the page."""
        self.make_ready()
        self.page.arm()
        self.until(lambda: self.armed() and self.page.shown["state"] == "armed", 1000)

    def drive(self, verb: str = "forward", mode: str = "continuous", ms: int = 600) -> None:
        """Armed, pressed, on its way."""
        self.arm()
        # After boot a way must look free for a while before the board believes it.
        way = 1 << codes.DIRECTIONS.index(verb)
        self.until(lambda: not self.board.app.obstacles.blocked & way, 600)
        self.page.press(verb, mode)
        self.until(lambda: not self.neutral(), 10 + self.page.delay_ms)
        self.run(ms)
        assert not self.neutral(), self.why()

    def kill_host(self) -> None:
        """SIGKILL: the port closes, the page's socket breaks."""
        assert self.host is not None
        self.host.link.close()
        self.page.open_socket = False
        self.host = None

    def start_host(self) -> None:
        """A new daemon; the page connects to it by itself."""
        self.host = Host(self.cable, self.world.lidar.receive, self.now_s)
        self.page.open(self.host)

    # -- promises --

    def stays_still(self, ms: int) -> None:
        """Nothing reaches the chair for `ms`, and after its own braking it stands."""
        for k in range(ms):
            self.one_ms()
            assert self.harmless(), self.why()
            assert k < 2500 or self.stands(), self.why()

    def comes_to_rest(self) -> None:
        """The chair itself stops, and nothing pushes it meanwhile."""
        for _ in range(3000):
            self.one_ms()
            assert self.harmless(), self.why()
            if self.stands():
                return
        raise AssertionError(f"still moving: {self.why()}")

    def needs_a_new_press(self, verb: str = "forward") -> None:
        """P14: what was pressed never moves again, though held on; a new press does.

        After a disarming, driving must also be switched on again first.
        """
        self.comes_to_rest()
        self.stays_still(600)
        if not self.armed():
            self.page.release()
            self.stays_still(50)
            self.page.press(verb)  # a new press alone does not do
            self.stays_still(300)
            self.page.release()
            self.arm()
            self.stays_still(100)
        self.page.press(verb)
        self.until(lambda: not self.neutral(), 60)
        self.until(lambda: not self.stands(), 1500)
