"""Connects to the board for one command of the terminal, while no daemon runs."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

from gazechair.base.health import Health
from gazechair.board import ports
from gazechair.board.link import BoardLink
from gazechair.commissioning.board_settings import BoardSettings, SettingsError

_CONNECT_S = 6.0
_POLL_S = 0.02


@contextlib.contextmanager
def connected(port: str) -> Iterator[BoardSettings]:
    """The settings of the board on `port` ("auto": found by USB ids); the daemon must not run."""
    health = Health("board")
    link = BoardLink(ports.finder(port, ports.BOARD), health)
    link.start()
    try:
        wait_for_board(link, health, time.monotonic() + _CONNECT_S)
        yield BoardSettings(link)
    finally:
        link.stop()


def wait_for_board(link: BoardLink, health: Health, end_s: float) -> None:
    """Wait until the board reports its state; SettingsError if not by `end_s` (monotonic)."""
    while link.state() is None:
        if time.monotonic() > end_s:
            why = health.detail or "no answer"
            raise SettingsError(f"no board: {why}; stop gazechair run if it holds the port")
        time.sleep(_POLL_S)
