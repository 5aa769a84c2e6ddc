"""The link's thread on pseudo terminals: found, lost, found again, in any order."""

from __future__ import annotations

import os
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from gazechair.base.health import Health
from gazechair.board.board_commands import Clearance, Command
from gazechair.board.events import SettingReply
from gazechair.board.link import BoardLink
from gazelink import codes
from patience import wait_until

PATIENCE_S = 30


@pytest.fixture
def link(cable: Any) -> Iterator[BoardLink]:
    link = BoardLink(lambda: [str(cable.path)], Health("board"))
    link.start()
    yield link
    link.stop()


def test_it_connects_and_publishes_the_state(cable: Any, link: BoardLink) -> None:
    cable.state = {"status": codes.ARMED, "edge": 3}

    def seen() -> tuple[str, int] | None:
        state = link.state()
        return state and (state.state_name, state.edge)

    wait_until(lambda: seen() == ("armed", 3), "the state arrives")
    wait_until(lambda: link.health.state == "ok", "the link is healthy")
    board = link.board()
    assert board is not None
    assert board.name == "fake"


def test_a_ping_comes_back(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    round_trip_s = link.ping(PATIENCE_S)
    assert round_trip_s is not None
    assert round_trip_s > 0


def test_an_answer_about_another_setting_is_not_the_callers(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    answers: list[SettingReply | None] = []
    asking = threading.Thread(
        target=lambda: answers.append(link.setting(codes.SETTING_GET, 3, timeout_s=PATIENCE_S))
    )
    asking.start()
    wait_until(
        lambda: [row for row in cable.received("setting") if row["index"] == 3], "it is asked"
    )
    for index, value in ((4, 44), (3, 33)):
        with cable._lock:
            reply = cable.board.setting_reply(index=index, value=value)
        cable.say(reply)
        assert link.ping(PATIENCE_S) is not None  # the link has read the answer by now
    asking.join(PATIENCE_S)
    assert answers == [SettingReply(codes.SETTING_GET, 3, 33, 0)]


def test_commands_clearance_and_orders_reach_the_board(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    now_s = time.monotonic()
    link.clearance(Clearance(5, codes.SIMULATED, now_s))
    link.order(codes.ARM, codes.DRIVER)
    link.command(Command(codes.LEFT, codes.STEP, 9, codes.DRIVER, now_s + 0.3))
    wait_until(lambda: cable.received("clearance"), "the clearance arrives")
    wait_until(lambda: cable.received("order"), "the order arrives")
    wait_until(lambda: cable.received("command")[-1]["edge"] == 9, "the command arrives")


def test_a_pulled_cable_is_lost_and_plugged_back_found(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    session = cable.board.session
    cable.pull()
    wait_until(lambda: link.health.state == "lost", "the loss is noticed")
    assert link.health.reason == "board_lost"
    assert str(cable.path) in link.health.detail
    assert link.state() is None
    cable.plug()
    wait_until(lambda: link.health.state == "ok", "it is found again")
    assert cable.board.session not in (0, session)


def test_a_restarted_board_gets_a_new_session(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    session = cable.board.session
    with cable._lock:
        cable.board.restart()
        hello = cable.board.hello()
    cable.say(hello)
    wait_until(lambda: cable.board.session not in (0, session), "a new session begins")
    wait_until(lambda: link.health.state == "ok", "the link is healthy")


def test_the_host_may_come_first(board: Any, new_cable: Callable[..., Any], tmp_path: Path) -> None:
    link = BoardLink(lambda: [str(tmp_path / "board")], Health("board"))
    link.start()
    try:
        wait_until(lambda: link.health.state == "lost", "the missing port is told")
        assert "is not there" in link.health.detail
        cable = new_cable(board, tmp_path / "board")
        try:
            wait_until(lambda: link.health.state == "ok", "the board is found")
        finally:
            cable.close()
    finally:
        link.stop()


def test_a_silent_port_is_the_wrong_one_and_the_next_is_tried(cable: Any, tmp_path: Path) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    silent = os.ttyname(slave)
    reasons: list[str] = []
    health = Health("board", on_change=lambda: reasons.append(health.reason))
    link = BoardLink(lambda: [silent, str(cable.path)], health, answer_s=0.3)
    link.start()
    try:
        wait_until(lambda: health.state == "ok", "the second port is found")
        assert "wrong_port" in reasons
    finally:
        link.stop()
        os.close(master)
        os.close(slave)


def test_a_board_that_does_not_read_is_busy_and_nothing_blocks(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    cable.reading = False

    def crowded() -> bool:
        link.clearance(Clearance(0, codes.REAL, time.monotonic()))
        return link.health.reason == "board_busy"

    wait_until(crowded, "the full line is noticed")
    assert link.health.state == "degraded"
    cable.reading = True
    wait_until(lambda: link.health.state == "ok", "it recovers")


def test_garbage_on_the_line_does_no_harm(cable: Any, link: BoardLink) -> None:
    wait_until(lambda: link.state() is not None, "a state arrives")
    for _ in range(20):
        cable.say(os.urandom(200))
    before = link.state()
    wait_until(lambda: link.state() is not before, "states go on")
    wait_until(lambda: link.health.state == "ok", "the link is healthy")


def test_another_version_is_told(cable: Any, tmp_path: Path) -> None:
    cable.board.schema_hash ^= 1
    link = BoardLink(lambda: [str(cable.path)], Health("board"))
    link.start()
    try:
        wait_until(lambda: link.health.reason == "version_differs", "the version is told")
        assert link.state() is None
    finally:
        link.stop()


def test_a_file_and_a_busy_port_are_refused_in_plain_words(
    cable: Any, link: BoardLink, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("no port")
    wait_until(lambda: link.state() is not None, "the port is taken")
    for path, words in ((tmp_path / "file", "no serial port"), (cable.path, "in use")):
        other = BoardLink(lambda path=path: [str(path)], Health("board"))
        other.start()
        try:
            wait_until(lambda other=other: other.health.state == "lost", "the refusal is told")
            assert words in other.health.detail
        finally:
            other.stop()


def test_it_stops_while_searching() -> None:
    link = BoardLink(list, Health("board"))
    link.start()
    wait_until(lambda: link.health.state == "lost", "nothing is found")
    assert "no board found" in link.health.detail
    link.stop()
    assert not any(thread.name == "board-link" for thread in threading.enumerate())
