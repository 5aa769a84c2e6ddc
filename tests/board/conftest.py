"""Boards for these tests: the emulated Teensy, or with --board PORT a real one."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from gazelink import codes
from liveboard import EmulatedLiveBoard, LiveBoard


@pytest.fixture(scope="session")
def firmware_flash(m7: Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Flash memory of an emulated Teensy with this checkout's firmware on it."""
    folder = tmp_path_factory.mktemp("flashed")
    board = EmulatedLiveBoard(m7, folder, None)
    board.board.install()
    board.start()
    try:
        board.connect()
        return board.flash
    finally:
        board.stop()


@pytest.fixture
def emulated(firmware_flash: bytes, m7: Path, tmp_path: Path) -> Iterator[EmulatedLiveBoard]:
    """The firmware just switched on, on an emulated Teensy of its own."""
    board = EmulatedLiveBoard(m7, tmp_path, firmware_flash)
    board.start()
    try:
        yield board
        assert board.host.safety != codes.ARMED or board.world.relay.closed
    finally:
        board.stop()


@pytest.fixture
def board(request: pytest.FixtureRequest) -> Iterator[LiveBoard]:
    """The real board of --board PORT, its relay held open; else the emulated one."""
    port = request.config.getoption("--board")
    if port is None:
        yield request.getfixturevalue("emulated")
        return
    real = LiveBoard(Path(port))
    try:
        yield real
    finally:
        real.stop()
