"""BoardLink: the thread that connects to the board and reconnects after any failure."""

from __future__ import annotations

import contextlib
import logging
import os
import select
import threading
import time
from collections.abc import Callable

from gazechair.base import health as h
from gazechair.base.health import Health
from gazechair.base.latest_value import Clock, Latest
from gazechair.base.throttled_log import ThrottledLog
from gazechair.board import ports
from gazechair.board.board_commands import Bypass, Clearance, Command
from gazechair.board.events import (
    Event,
    FaultText,
    Pong,
    SessionBegun,
    SessionEnded,
    SettingReply,
    VersionDiffers,
)
from gazechair.board.link_quality import ANSWER_S, LinkJudge
from gazechair.board.protocol import LinkProtocol, Witness, random_session
from gazechair.board.serial_port import PortError, SerialPort
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.board.state_log import StateLog
from gazechair.board.zone import NOT_KNOWN, BoardZone

_BACK_OFF_S = (0.1, 1.0)
_MAX_WAIT_S = 0.05

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)

# Reasons of a board that repeats its last message instead of beginning a session.
_DOES_NOT_START = ("watchdog_boots", "no_hard_timer")


class BoardLink:
    """The connection to the board. All methods may be called from any thread and never wait."""

    def __init__(
        self,
        find_ports: ports.PortFinder,
        health: Health,
        on_change: Callable[[], None] = lambda: None,
        clock: Clock = time.monotonic,
        answer_s: float = ANSWER_S,
        on_zone: Callable[[BoardZone], None] = lambda _zone: None,
        on_state: Callable[[BoardState], None] = lambda _state: None,
        witness: Witness = lambda _way, _now_s, _frame: None,
        traced: bool = False,
    ) -> None:
        """`find_ports` lists the paths to try; `on_change` is called, from the link's own thread,
        after each STATE frame and each begin or end of a session. `answer_s` is for tests.
        `on_zone` is called from that thread with how the board stops, whenever that changes,
        `on_state` with each STATE frame.
        `witness` sees every frame, with the link locked: it must not wait. `traced`: the board's
        trace, too."""
        self.health = health
        self._find_ports = find_ports
        self._on_change = on_change
        self._on_zone = on_zone
        self._on_state = on_state
        self._clock = clock
        self._judge = LinkJudge(answer_s)
        self._story = StateLog()
        self._lock = threading.Lock()
        self._protocol = LinkProtocol(random_session, witness, traced)
        self._port: SerialPort | None = None
        self._unsent = b""
        self._unsent_since_s = 0.0
        self._state: Latest[BoardState] = Latest(clock)
        self._stats: Latest[BoardStats] = Latest(clock)
        self._round_trip: Latest[float] = Latest(clock)
        self._setting: Latest[SettingReply] = Latest(clock)
        self._failed_path = ""  # the search continues after it
        self._stopping = threading.Event()
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_write, False)
        self._thread = threading.Thread(target=self._run, name="board-link", daemon=True)

    def start(self) -> None:
        """Begin to search for the board."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the port; the board goes neutral by itself."""
        self._stopping.set()
        self._wake()
        if self._thread.is_alive():
            self._thread.join(5.0)

    # Values to send

    def command(self, command: Command) -> None:
        """The latest command: written at once when it differs from the last."""
        with self._lock:
            self._protocol.command(command, self._clock())
            self._flush()

    def order(self, action: int, owner: int) -> None:
        """Arm, disarm, emergency stop or reset (codes), acted on once by the board."""
        with self._lock:
            self._protocol.order(action, owner, self._clock())
            self._flush()

    def clearance(self, clearance: Clearance) -> None:
        """What the newest scans leave free: written at once."""
        with self._lock:
            self._protocol.clearance(clearance, self._clock())
            self._flush()

    def bypass(self, bypass: Bypass | None) -> None:
        """The caretaker's bypass button: written at once when pressed or released (None)."""
        with self._lock:
            self._protocol.bypass(bypass, self._clock())
            self._flush()

    # Values from the board

    def state(self) -> BoardState | None:
        """The newest state, None while there is no session."""
        return self._state.get()

    def stats(self) -> BoardStats | None:
        """The newest statistics, None before the first."""
        return self._stats.get()

    def board(self) -> BoardId | None:
        """The connected board; None while there is no session."""
        return self._protocol.board

    def ping(self, timeout_s: float = 1.0) -> float | None:
        """Measure a round trip, seconds; None when no answer came. Waits, unlike the others."""
        last = self._round_trip.entry()
        with self._lock:
            self._protocol.request_ping()
            self._flush()
        entry = self._round_trip.wait(timeout_s, 0 if last is None else last.version)
        return None if entry is None else entry.value

    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None:
        """Request a setting (codes.SETTING_...); None when no answer came. Waits, as ping."""
        last = self._setting.entry()
        end_s = time.monotonic() + timeout_s
        with self._lock:
            self._protocol.request_setting(request, index, value)
            self._flush()
        while True:
            left_s = end_s - time.monotonic()
            last = self._setting.wait(left_s, 0 if last is None else last.version)
            # The link requests the relay setting itself; that answer is not the caller's.
            if last is None or (last.value.request, last.value.index) == (request, index):
                return None if last is None else last.value

    # The thread

    def _run(self) -> None:
        back_off_s = _BACK_OFF_S[0]
        while not self._stopping.is_set():
            begun = False
            try:
                path = self._next_path()
                if path is None:
                    self.health.set(h.LOST, "board_lost", ports.nothing_found(ports.BOARD))
                else:
                    begun = self._try(path)
            except Exception as error:  # whatever is wrong, the board must be looked for again
                throttled.warn("board link: an error", exc_info=True)
                self.health.set(h.LOST, "board_lost", f"{type(error).__name__}: {error}")
            back_off_s = _BACK_OFF_S[0] if begun else min(back_off_s * 2, _BACK_OFF_S[1])
            self._stopping.wait(back_off_s)

    def _next_path(self) -> str | None:
        paths = self._find_ports()
        if not paths:
            return None
        after = paths.index(self._failed_path) + 1 if self._failed_path in paths else 0
        return paths[after % len(paths)]

    def _try(self, path: str) -> bool:
        """Serve the port at `path` until it fails; True if a board has answered there."""
        try:
            port = SerialPort(path)
        except PortError as error:
            self._failed_path = path
            self.health.set(h.LOST, "board_lost", str(error))
            return False
        log.info("trying %s", path)
        vanished = ""
        try:
            self._serve(port)
        except PortError as error:
            vanished = str(error)
        finally:
            with self._lock:
                self._port = None
                self._protocol.opened(self._clock())
            port.close()
            self._forget()
        if vanished:
            log.warning("%s", vanished)
            self.health.set(h.LOST, "board_lost", vanished)
        self._failed_path = "" if self._judge.answered else path
        return self._judge.answered

    def _serve(self, port: SerialPort) -> None:
        with self._lock:
            self._port = port
            self._unsent = b""
            self._protocol.opened(self._clock())
        self._judge.opened(port.path, self._clock())
        poller = select.poll()
        poller.register(self._wake_read, select.POLLIN)
        while not self._stopping.is_set():
            with self._lock:
                self._flush()
                out = select.POLLOUT if self._unsent else 0
                wait_s = min(self._protocol.due_s() - self._clock(), _MAX_WAIT_S)
            poller.register(port, select.POLLIN | out)
            ready = poller.poll(max(0.0, wait_s) * 1000)
            if any(fd == self._wake_read for fd, _ in ready):
                os.read(self._wake_read, 64)
            # Readable without data is how a vanished pseudo terminal shows.
            hung_up = any(fd == port.fileno() and what & ~select.POLLOUT for fd, what in ready)
            data = port.read()
            if hung_up and not data:
                raise PortError(f"{port.path} has vanished")
            now_s = self._clock()
            with self._lock:
                events = self._protocol.feed(data, now_s) + self._protocol.check(now_s)
                unsent_s = now_s - self._unsent_since_s if self._unsent else 0.0
            self._publish(events, port, now_s)
            verdict = self._judge.verdict(unsent_s, now_s)
            if verdict is not None:
                self.health.set(verdict.state, verdict.reason, verdict.detail)
                if verdict.give_up:
                    log.warning("%s", verdict.detail)
                    return

    def _flush(self) -> None:
        # Under the lock, from any thread: hand over what is due, as far as the port takes it.
        if self._port is None:
            return
        now_s = self._clock()
        if not self._unsent:
            self._unsent = self._protocol.poll(now_s)
            self._unsent_since_s = now_s
        if self._unsent:
            try:
                self._unsent = self._unsent[self._port.write(self._unsent) :]
            except PortError:
                self._port = None  # the thread finds out by reading
            if self._unsent and threading.current_thread() is not self._thread:
                self._wake()

    def _publish(self, events: list[Event], port: SerialPort, now_s: float) -> None:
        changed = False
        for event in events:
            if isinstance(event, BoardState):
                self._judge.received(now_s)
                self._story.note(event)
                self._state.put(event, event.received_s)
                self._on_state(event)
                changed = True
            elif isinstance(event, BoardStats):
                self._stats.put(event, event.received_s)
            elif isinstance(event, BoardZone):
                self._on_zone(event)
            elif isinstance(event, Pong):
                self._round_trip.put(event.round_trip_s)
            elif isinstance(event, SettingReply):
                self._setting.put(event)
            elif isinstance(event, FaultText):
                log.error("the board says: %s: %s", event.reason, event.detail)
                if event.reason in _DOES_NOT_START:
                    self._judge.refuses(event.reason, event.detail, now_s)
            elif isinstance(event, SessionBegun):
                log.info(
                    "board %s %s on %s, session %d",
                    event.board.name,
                    event.board.version,
                    port.path,
                    event.board.session,
                )
                self._judge.began(now_s)
                changed = True
            elif isinstance(event, SessionEnded):
                log.warning("session ended: %s", event.detail)
                self._judge.ended(now_s)
                self._forget()
                self.health.set(h.LOST, "board_lost", event.detail)
            elif isinstance(event, VersionDiffers):
                self._judge.differs(event.detail, now_s)
        if changed:
            self._on_change()

    def _forget(self) -> None:
        # Values from an ended session are not current.
        self._on_zone(NOT_KNOWN)
        self._state.clear()
        self._story.forget()
        self._on_change()

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):  # full: it is awake already
            os.write(self._wake_write, b"w")
