"""Page, host and the whole chair in virtual time, in one process."""

from __future__ import annotations

from collections.abc import Callable

from gazeboard.boards import bank_layout as layout
from gazelink import codes
from gazesim.chair_rig import ChairRig
from gazesim.lockstep_host import Host
from gazesim.lockstep_page import Page
from gazesim.rooms import Room
from gazesim.world import ONE, Mount


class Lockstep(ChairRig):
    """The whole chair; `page` is the driver's. Times are milliseconds of the board's own ticks."""

    def __init__(
        self, room: str | Room = "open", start_us: int = 0, mounts: tuple[Mount, ...] = ONE
    ) -> None:
        super().__init__(room, start_us=start_us, mounts=mounts)
        self._mounts = mounts
        self.host: Host | None = self._new_host()
        self.page = Page(self.host)
        self._frames = 0
        self.unheard_ms = 0
        """Milliseconds since the board last decoded a frame."""
        self.watchers: list[Callable[[], None]] = []

    def _new_host(self) -> Host:
        asks = [lidar.receive for lidar in self.world.lidars]
        return Host(self.cable, asks, self.now_s, self._mounts)

    def one_ms(self) -> None:
        """One step."""
        super().one_ms()
        app = self.app
        frames = app.link._decoder.ok if app is not None else self._frames
        self.unheard_ms = 0 if frames != self._frames else self.unheard_ms + 1
        self._frames = frames
        for watch in self.watchers:
            watch()

    def host_ms(self) -> None:
        """The page, then the host."""
        if self.host is not None:
            self.page.one_ms(self.now_ms)
            self.host.scan(self.world.scans)
            self.host.one_ms(self.now_ms)

    # -- state --

    def connected(self) -> bool:
        """True if host and board are in the same session."""
        known = None if self.host is None else self.host.link.board()
        if self.board.app is None or known is None:
            return False
        return bool(self.board.app.link._session == known.session)

    def ticks(self) -> int:
        """The board's own count of ticks since its reset."""
        return self.bank.u32(layout.TICK_MS_AT)

    def why(self) -> str:
        """The situation in one line, for failed assertions."""
        refused = [] if self.host is None else [f"refusals {self.host.refusals[-3:]}"]
        return "; ".join([super().why(), *refused])

    # -- actions of people --

    def make_ready(self) -> None:
        """Run until nothing prevents arming."""
        self.until(lambda: self.connected() and not self.armed(), 6000)
        self.until(lambda: self.page.shown.get("arm_reason") == "none", 6000)

    def arm(self) -> None:
        """Run until the page has armed the board."""
        self.make_ready()
        self.page.arm()
        self.until(lambda: self.armed() and self.page.shown["state"] == "armed", 1000)

    def drive(self, verb: str = "forward", mode: str = "continuous", ms: int = 600) -> None:
        """Arm, press, and run for `ms` after the wipers have moved."""
        self.arm()
        # After boot a direction must be free for a while before the board unblocks it.
        way = 1 << codes.DIRECTIONS.index(verb)
        self.until(lambda: not self.board.app.obstacles.blocked & way, 600)
        self.page.press(verb, mode)
        self.until(lambda: not self.neutral(), 10 + self.page.delay_ms)
        self.run(ms)
        assert not self.neutral(), self.why()

    def kill_host(self) -> None:
        """As by SIGKILL: the port closes, the page's socket breaks."""
        assert self.host is not None
        self.host.link.close()
        self.page.open_socket = False
        self.host = None

    def start_host(self) -> None:
        """Start a new daemon; the page connects to it by itself."""
        self.host = self._new_host()
        self.page.open(self.host)

    def another_page(self, role: str = "driver") -> Page:
        """Open another page: from now on it lives beside the driver's."""
        assert self.host is not None
        page = Page(self.host, role)
        self.watchers.append(lambda: page.one_ms(self.now_ms))
        return page

    # -- promises --

    def stays_still(self, ms: int) -> None:
        """Assert that nothing reaches the chair for `ms`, and that it stands once it has braked."""
        for k in range(ms):
            self.one_ms()
            assert self.harmless(), self.why()
            assert k < 2500 or self.stands(), self.why()

    def needs_a_new_press(self, verb: str = "forward") -> None:
        """Assert P14: the old press never moves the chair again, even if held; a new press does.

        After a disarming, driving must also be switched on again first.
        """
        self.comes_to_rest()
        self.stays_still(600)
        if not self.armed():
            self.page.release()
            self.stays_still(50)
            self.page.press(verb)  # a new press alone is not enough
            self.stays_still(300)
            self.page.release()
            self.arm()
            self.stays_still(100)
        self.page.press(verb)
        self.until(lambda: not self.neutral(), 60)
        self.until(lambda: not self.stands(), 1500)
