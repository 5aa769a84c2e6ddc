"""`gazechair tune`: gives the tuning what it needs, a board, lidars, a keyboard."""

from __future__ import annotations

import contextlib
import select
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator

from gazechair.base.health import Health
from gazechair.base.state_folder import state_folder
from gazechair.board import ports
from gazechair.board.board_commands import Clearance
from gazechair.board.link import BoardLink
from gazechair.commissioning.board_settings import BoardSettings
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.armed_session import Hands
from gazechair.commissioning.tune.forward import ForwardRecording
from gazechair.commissioning.tune.forward_runner import ForwardRunner
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazechair.commissioning.tune.runner import Runner
from gazechair.commissioning.tune.tuning import Tuning
from gazechair.commissioning.watched_areas import PERMITTED_S, with_eyes
from gazechair.config.settings import Config
from gazechair.sensing.inbox.feed import Feed
from gazechair.sensing.lidar import LidarService
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazechair.service.board_connection import wait_for_board
from gazelink import codes

_CONNECT_S = 10.0
_POLL_S = 0.05
_GO = "\nEnter: go. Anything else: leave all as it is. "


def tune(config: Config, profile: str, dry_run: bool, say: Callable[[str], None]) -> None:
    """Run `gazechair tune` on the board and lidars of `config`. TuneError, SettingsError."""
    with _board_and_lidars(config) as (link, looked, odometry):
        _ready(link)
        with _keyboard() as pressed:
            hands = Hands(link, time.monotonic, time.sleep, pressed, say)

            def record(believed: TurnNumbers, neutral_count: int) -> list[Recording]:
                looked.set()
                time.sleep(PERMITTED_S)
                return Runner(hands).run(believed, neutral_count)

            def straight() -> list[ForwardRecording]:
                _ready(link)
                return ForwardRunner(hands, odometry.latest.entry).run()

            keep = ForwardStore(state_folder(config.web.state_folder)).keep
            tuning = Tuning(BoardSettings(link), record, say, confirmed, straight, keep)
            tuning.run(profile, dry_run)


@contextlib.contextmanager
def _board_and_lidars(
    config: Config,
) -> Iterator[tuple[BoardLink, threading.Event, OdometryService]]:
    """The link, an event to set once a person has checked the area, and odometry."""
    board, eyes, looked = Health("board"), Health("lidar"), threading.Event()
    fitted = tuple(lidar for lidar in config.lidar if lidar.kind != "off")
    obeys = Obeys(Health("motion"), lambda: None)
    odometry = OdometryService(fitted, Health("odometry"), obeys)
    feed = Feed([odometry.inbox_fd])
    link = BoardLink(
        ports.finder(config.board.port, ports.BOARD),
        board,
        on_zone=lambda zone: lidars.zone(zone),
        on_state=feed.board,
    )

    def report(clearance: Clearance) -> None:
        link.clearance(with_eyes(clearance) if looked.is_set() else clearance)

    lidars = LidarService(config.lidar, config.footprint, report, eyes, inbox_fds=feed.fds)
    link.start()
    try:
        lidars.start()
        odometry.start()
        end_s = time.monotonic() + _CONNECT_S
        wait_for_board(link, board, end_s)
        _wait_for_lidars(link, eyes, end_s)
        yield link, looked, odometry
    finally:
        lidars.stop()
        link.stop()
        odometry.stop()


def _wait_for_lidars(link: BoardLink, eyes: Health, end_s: float) -> None:
    old = 1 << codes.OBSTACLE_DATA_OLD
    while (state := link.state()) is not None and state.faults & old:
        if time.monotonic() > end_s:
            raise TuneError(f"no lidar: {eyes.detail or 'no data'}; a chair turns only seeing")
        time.sleep(_POLL_S)


def _ready(link: BoardLink) -> None:
    """Wait until nothing prevents arming, for causes that pass by themselves."""
    end_s = time.monotonic() + _CONNECT_S
    while (state := link.state()) is not None and state.arm_reason:
        if time.monotonic() > end_s:
            raise TuneError(
                f"the board is not ready: {state.arm_reason_name}; see gazechair doctor"
            )
        time.sleep(_POLL_S)


def confirmed() -> bool:
    """Ask at the terminal: True for an Enter after the question. TuneError without a terminal."""
    if not sys.stdin.isatty():
        raise TuneError("nobody at the keyboard, who could stop it; run it in a terminal")
    termios.tcflush(sys.stdin, termios.TCIFLUSH)  # what was typed before is no answer
    sys.stdout.write(_GO)
    sys.stdout.flush()
    line = sys.stdin.readline()
    return line.endswith("\n") and not line.strip()  # Ctrl-D ends a line without one


@contextlib.contextmanager
def _keyboard() -> Iterator[Callable[[], bool]]:
    """A function to poll: has any key been pressed since the last call?"""
    if not sys.stdin.isatty():
        yield lambda: False  # confirmed() refuses before anything moves
        return
    before = termios.tcgetattr(sys.stdin)
    raw = False

    def pressed() -> bool:
        nonlocal raw
        if not raw:  # the confirmation before reads a whole line
            tty.setcbreak(sys.stdin, termios.TCSANOW)
            raw = True
        return bool(select.select([sys.stdin], [], [], 0)[0])

    try:
        yield pressed
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
        termios.tcflush(sys.stdin, termios.TCIFLUSH)
