"""An emulation that ends fails the test that uses it, with its reason: it is no reset."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from liveboard import EmulatedLiveBoard, EmulationEnded


@pytest.fixture
def board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[EmulatedLiveBoard]:
    """Started, with a QEMU that says why it ends, and ends."""
    qemu = tmp_path / "bin" / "qemu-system-arm"
    qemu.parent.mkdir()
    qemu.write_text("#!/bin/sh\necho 'no such machine' >&2\nexit 3\n")
    qemu.chmod(0o755)
    monkeypatch.setenv("PATH", str(qemu.parent), prepend=":")
    (tmp_path / "firmware.elf").touch()
    board = EmulatedLiveBoard(tmp_path, tmp_path, None)
    try:
        board.start()
        yield board
    finally:
        board.stop()


def test_while_the_test_waits(board: EmulatedLiveBoard) -> None:
    with pytest.raises(EmulationEnded, match="ended with 3: no such machine"):
        board.connect()


def test_in_the_background(board: EmulatedLiveBoard) -> None:
    board.start_background()
    board._thread.join(10.0)
    assert not board.cable.port.plugged, "nobody waits for its answer"
    with pytest.raises(EmulationEnded, match="ended with 3: no such machine"):
        board.stop_background()
