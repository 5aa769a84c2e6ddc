"""Drives of a board that is a process, in real time: their logs replay with equal decisions."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import gazesetup
from e2e.running import Running
from gazeboard.core import limits
from gazechair.base.health import Health
from gazechair.blackbox.writer import LogWriter, files
from gazechair.board.board_commands import Clearance, Command
from gazechair.board.link import BoardLink
from gazedemo.stack import Stack
from gazelink import codes, messages
from gazereplay.replay import replay
from gazesim.simulator import Simulator

_LIMIT_S = 60.0  # for what does come; the machine may stall
_PASS_S = 0.02


class Rig:
    """The simulator with its board's process, and a host's link that is logged."""

    def __init__(self, folder: Path, interpreter: str) -> None:
        self._folder = folder
        self.moving = 0
        """States that reported a motion."""
        self._seen: list[tuple[str, float, bytes]] = []
        self._rig = Simulator(folder, interpreter, "open")
        port = str(folder / "board")
        self._link = BoardLink(lambda: [port], Health("board"), witness=self._saw, traced=True)
        self._held = (codes.STOP, codes.STEP)
        self._edge = 0
        self._rig.start()
        self._link.start()

    def _saw(self, way: str, at_s: float, frame: bytes) -> None:
        self._seen.append((way, at_s, frame))
        if frame[messages.TYPE_AT] == messages.STATE.type_id:
            self.moving += frame[messages.HEADER_SIZE] >> 4 != codes.STOPPED

    def run(self, seconds: float = _LIMIT_S, until: Callable[[], bool] = lambda: False) -> None:
        """So long, or until that is so."""
        end_s = time.monotonic() + seconds
        while (now_s := time.monotonic()) < end_s and not until():
            self._link.clearance(Clearance(0, codes.SIMULATED, now_s))
            self._link.command(Command(*self._held, self._edge, codes.DRIVER, now_s + 0.3))
            self._rig.run(until_s=now_s + _PASS_S)

    def reports(self, name: str, value: int) -> bool:
        """A field of the board's newest state."""
        state = self._link.state()
        return state is not None and getattr(state, name) == value

    def arm(self) -> None:
        """Armed by the driver."""
        self.press(codes.STOP)
        end_s = time.monotonic() + _LIMIT_S
        while not self.reports("state", codes.ARMED):
            assert time.monotonic() < end_s
            self.run(2.0, until=lambda: self.reports("arm_reason", codes.NO_REASON))
            self._link.order(codes.ARM, codes.DRIVER)
            self.run(0.5, until=lambda: self.reports("state", codes.ARMED))

    def press(self, verb: int, mode: int = codes.CONTINUOUS) -> None:
        """From now on."""
        self._edge = self._edge % 255 + 1
        self._held = (verb, mode)

    def close(self) -> Path:
        """The file, when all has ended."""
        self._link.stop()
        self._rig.stop()
        log = LogWriter(self._folder / "log", 10**9, 1e9, free_bytes=lambda _: 10**10)
        for way, at_s, frame in self._seen:
            log.write(way, int(at_s * 1e9), frame)
        path = log.path
        log.close()
        assert path is not None
        return path


@pytest.fixture
def folder() -> Iterator[Path]:
    """Short: the path of a unix socket is."""
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        yield Path(name)


def test_a_drive_of_a_board_process(
    folder: Path, micropython: gazesetup.MicroPython, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(folder, str(micropython.path))
    try:
        while rig.moving < 100:  # where the machine stalls, it takes several tries
            rig.arm()
            rig.press(codes.FORWARD)
            rig.run(0.6)
            rig.press(codes.LEFT, codes.STEP)
            rig.run(1.0)
            rig.press(codes.STOP)
            rig.run(0.3)
    finally:
        path = rig.close()
    result = replay(path)
    assert result.difference is None
    assert result.armed > 300
    assert result.compared > 0.05 * result.ticks  # a stalled machine makes the board skip states
    monkeypatch.setattr(limits, "RELAY_HOLD_MS", limits.RELAY_HOLD_MS + 30)
    assert "arming" in str(replay(path).difference)


@pytest.mark.long
def test_drives_of_the_demo(micropython: gazesetup.MicroPython, folder: Path) -> None:
    """With the whole host and its black box; the board is reset, the host is killed."""
    with Stack(str(micropython.path), room="open") as stack:
        chair = Running(stack)
        chair.take_a_place()
        for event in ("", "board_reset", "kill", ""):
            chair.drive()
            for verb in ("left", "right", "forward"):
                chair.player.press(verb)
                time.sleep(1.5)
                chair.player.release()
                time.sleep(0.3)
            if event == "kill":
                chair.signal_host(9)
                chair.restart_host()
            elif event:
                chair.sim.do("inject", fault=event)
                time.sleep(2.0)
        chair.close()
        time.sleep(2.5)  # all is synced
        results = []
        for path in files(stack.folder / "state" / "log"):
            copy = folder / path.name
            copy.write_bytes(path.read_bytes())
            results.append(replay(copy))
    assert [result.difference for result in results] == [None] * len(results)
    assert len(results) == 2  # one for each start of the host
    assert sum(result.lives for result in results) == 3
    assert sum(result.armed for result in results) > 15000
