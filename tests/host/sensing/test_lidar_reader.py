"""One lidar's thread with a byte-accurate S2: each failure has its reason, and recovers."""

from __future__ import annotations

import fcntl
import termios
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar import device as device_module
from gazechair.sensing.lidar import reader as reader_module
from gazechair.sensing.lidar.nodes import Nodes
from gazechair.sensing.lidar.reader import Intake, Reader
from gazechair.sensing.lidar.stream import PERIODS_S, ByteStream
from gazechair.service import lidar_tools
from gazelink import codes
from gazesim.s2 import S2
from lidarrig import LidarRig, wait_for


class Rig(LidarRig):
    """The lidar, its reader, and every condition that was reported."""

    def __init__(self, path: Path, mode: str = "dense") -> None:
        super().__init__(path)
        self.reported: list[tuple[str, str]] = []
        config = LidarConfig(kind="s2", port=str(path), mode=mode)
        self.handed_on: list[float] = []
        self.reader = Reader(
            config, self._note, lambda *reported: self.handed_on.append(reported[1])
        )

    def _note(self) -> None:
        one = (self.reader.condition.state, self.reader.condition.reason)
        if not self.reported or self.reported[-1] != one:
            self.reported.append(one)

    def wait(self, condition: Callable[[], bool]) -> None:
        wait_for(condition, lambda: (self.reader.condition, self.reported))

    def wait_fresh(self) -> None:
        """Wait for a scan that was measured from now on."""
        now_s = time.monotonic()
        self.wait(lambda: (scan := self.reader.scan) is not None and scan.acquired_s > now_s)

    def wait_told(self, reason: str) -> None:
        """Wait until it is lost for `reason`."""
        self.wait(lambda: ("lost", reason) in self.reported)
        self.reported.clear()

    def close(self) -> None:
        self.reader.stop()
        super().close()


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    monkeypatch.setattr(reader_module, "_FIRST_S", 1.5)
    rig = Rig(tmp_path / "lidar")
    yield rig
    rig.close()


def test_each_fault_has_its_reason_and_heals_by_itself(rig: Rig) -> None:
    beams = rig.device.beams
    rig.reader.start()
    rig.wait_fresh()
    assert rig.reported == [("starting", "lidar_starting"), ("ok", "ok")]
    rig.reported.clear()

    beams.frozen = True
    assert rig.handed_on
    rig.wait_told("lidar_frozen")
    rig.handed_on.clear()
    rig.wait_told("lidar_frozen")  # it is restarted, and still repeats itself
    assert rig.handed_on == []
    assert rig.reader.scan is None
    assert ("ok", "ok") not in rig.reported
    beams.frozen = False
    rig.wait_fresh()

    rig.device.power_dip()
    rig.wait_told("lidar_silent")
    rig.wait_told("lidar_power")
    rig.wait_fresh()

    rig.device.stalled = True
    rig.wait_told("lidar_silent")
    rig.wait(lambda: "no RPLIDAR answers" in rig.reader.condition.detail)
    assert rig.reader.scan is None
    rig.device.stalled = False
    rig.wait_fresh()

    rig.device.mirror_blocked = True
    rig.wait_told("lidar_mirror")
    assert rig.reader.scan is None
    rig.device.mirror_blocked = False
    rig.wait_fresh()

    rig.unplug()
    rig.wait_told("lidar_lost")
    assert rig.reader.scan is None
    rig.plug()
    rig.wait_fresh()

    rig.device.protection_stop = True
    rig.wait_told("lidar_protection")
    rig.device.protection_stop = False
    rig.wait_fresh()
    assert rig.reader.condition.state == "ok"


def test_lost_and_damaged_bytes_are_lived_with(rig: Rig) -> None:
    rig.reader.start()
    rig.wait_fresh()
    rig.reported.clear()
    rig.device.drop = rig.device.corrupt = 0.0005
    rig.wait(lambda: rig.reader.stream is not None and rig.reader.stream.resyncs > 20)
    assert set(rig.reported) == {("ok", "ok")}
    rig.wait_fresh()
    assert rig.reader.stream is not None
    assert 0.01 < rig.reader.stream.lost_share < 0.2


def test_the_standard_scan_serves_too(tmp_path: Path) -> None:
    rig = Rig(tmp_path / "lidar", "standard")
    try:
        rig.reader.start()
        # Half as many as in the dense scan; where the machine stalls, a turn has some more or less.
        rig.wait(lambda: (scan := rig.reader.scan) is not None and 1500 < len(scan) < 1700)
        scan, stream = rig.reader.scan, rig.reader.stream
        assert scan is not None
        assert stream is not None
        assert scan.source == codes.SIMULATED
        assert scan.acquired_s <= time.monotonic() - 0.05
        rig.wait(lambda: stream.turns > 5 and 5.0 < stream.rate_hz < 12.0)
    finally:
        rig.close()


def test_a_port_that_another_program_holds_is_said(rig: Rig) -> None:
    with rig.path.open("rb", buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        rig.reader.start()
        rig.wait(lambda: "used by another program" in rig.reader.condition.detail)
    rig.wait_fresh()


def test_an_error_of_a_library_is_told_and_tried_again(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(_lidar: object) -> None:
        raise termios.error(5, "Input/output error")  # its plug goes while it is stopped

    with monkeypatch.context() as patch:
        patch.setattr(device_module.RPLidar, "stop", gone)
        rig.reader.start()
        rig.wait(lambda: "can't be written to" in rig.reader.condition.detail)
        patch.setattr(reader_module, "find_port", lambda _port: int("", 16))
        rig.wait(lambda: rig.reader.condition.detail.startswith("ValueError"))
    rig.wait_fresh()


def test_what_came_while_its_thread_stood_still_counts_as_old(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    gathered, paused = reader_module.Intake.gathered, threading.Event()
    seen_ahead_m: list[float] = []

    def slept(intake: Intake, stream: ByteStream) -> tuple[bytes, float]:
        if paused.is_set():
            paused.clear()
            time.sleep(0.2)  # the kernel keeps what was measured meanwhile
            rig.front_m, changed_s[0] = 1.5, time.monotonic()
            time.sleep(0.8)
        return gathered(intake, stream)

    def note() -> None:
        scan = rig.reader.scan
        if scan is not None and scan.acquired_s > changed_s[0]:
            ahead = np.abs(scan.angles_deg) < 8.0
            seen_m = scan.distances_m[ahead]
            seen_ahead_m.append(float(seen_m[seen_m > 0.0].max()))

    changed_s = [float("inf")]
    monkeypatch.setattr(reader_module.Intake, "gathered", slept)
    rig.reader._renewed = note
    rig.reader.start()
    rig.wait_fresh()
    paused.set()
    rig.wait(lambda: len(seen_ahead_m) > 20)
    assert max(seen_ahead_m) < 2.0
    assert rig.reader.condition.state == "ok"


def test_a_port_where_something_else_talks_is_refused_in_one_line(rig: Rig) -> None:
    rig.babble = b"\x55\xaa\x01" * 20
    rig.reader.start()
    rig.wait(lambda: rig.reader.condition.state == "lost")
    assert "lidar.port" in rig.reader.condition.detail
    assert "\n" not in rig.reader.condition.detail


class Arriving:
    """A device and a clock: bytes arrive in chunks, and each sleep may last longer than asked."""

    def __init__(self, chunk_s: float, stall_s: float = 0.0, silent_from_s: float = 9.0) -> None:
        self.now_s, self.looks = 0.0, 0
        self._chunk_s, self._stall_s, self._silent_from_s = chunk_s, stall_s, silent_from_s
        self._taken = 0

    def monotonic(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now_s += seconds + self._stall_s

    def read(self, timeout_s: float) -> bytes:
        self.looks += 1
        for at_s in (self.now_s, self.now_s + min(timeout_s, self._chunk_s)):
            chunks = int((min(at_s, self._silent_from_s) + 1e-9) / self._chunk_s)
            there = round(chunks * self._chunk_s * 67_200)
            if there > self._taken:
                self.now_s, self._taken, before = at_s, there, self._taken
                return bytes(there - before)
        self.now_s += timeout_s
        return b""


class Wanting:
    wants, byte_s = 1680, 1.0 / 67_200.0
    last_s: float | None = None


class Satisfied(Wanting):
    wants, last_s = 0, 0.0


class Flowing(Wanting):
    last_s = 0.0


def gathered(
    device: Arriving, monkeypatch: pytest.MonkeyPatch, stream: Wanting | None = None
) -> tuple[int, float]:
    with monkeypatch.context() as patch:
        patch.setattr(reader_module, "time", device)
        intake = Intake(device)  # type: ignore[arg-type]
        data, came_s = intake.gathered(stream or Wanting())  # type: ignore[arg-type]
    return len(data), came_s


@pytest.mark.parametrize("stream", [Wanting(), Flowing()])
@pytest.mark.parametrize("chunk_s", [0.00125, 0.005])
def test_a_quarter_turn_is_gathered_in_few_looks(
    monkeypatch: pytest.MonkeyPatch, chunk_s: float, stream: Wanting
) -> None:
    device = Arriving(chunk_s)
    count, came_s = gathered(device, monkeypatch, stream)
    assert count >= 1680
    assert came_s < 0.025 + 2.0 * max(chunk_s, 0.001)
    assert device.looks <= (4 if chunk_s > 0.002 else 2)


def test_what_is_computed_meanwhile_delays_no_look(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Arriving(0.00125)
    device.now_s = 0.006  # the newest bytes came at 0
    count, came_s = gathered(device, monkeypatch, Flowing())
    assert count >= 1680
    assert came_s < 0.025 + 2.0 * 0.00125


def test_a_stream_that_wants_nothing_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Arriving(0.00125)
    assert 0 < gathered(device, monkeypatch, Satisfied())[0] < 200
    assert device.looks == 1


def test_what_came_before_a_silence_is_not_made_younger(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Arriving(0.005, silent_from_s=0.01)
    count, came_s = gathered(device, monkeypatch)
    assert 0 < count < 1680
    assert came_s <= device.now_s - 0.004
    assert device.now_s < 0.04
    assert gathered(device, monkeypatch)[0] == 0


def test_a_machine_that_stands_still_ends_the_gathering(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Arriving(0.00125, stall_s=0.1, silent_from_s=0.012)
    assert 0 < gathered(device, monkeypatch)[0] < 1680
    assert device.now_s < 0.3
    assert gathered(Arriving(0.00125, stall_s=0.1), monkeypatch)[0] > 1680


class Keeping(Arriving):
    """Its kernel keeps the oldest 4095 unread bytes; 500 wait in the device, 2 ms away."""

    def __init__(self) -> None:
        super().__init__(0.00125)
        self.slept_s, self._kept = 0.0, [4095, 500]

    def read(self, timeout_s: float) -> bytes:
        if not self._kept:
            return super().read(timeout_s)
        self.now_s += self.slept_s
        self.slept_s = 0.002
        if len(self._kept) == 1:
            self._taken = round(self.now_s * 67_200)
        return bytes(self._kept.pop(0))


def test_after_a_pause_no_byte_counts_as_younger_than_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    device = Keeping()
    with monkeypatch.context() as patch:
        patch.setattr(reader_module, "time", device)
        intake = Intake(device)  # type: ignore[arg-type]
        device.slept_s = 1.0
        data, came_s = intake.gathered(Flowing())  # type: ignore[arg-type]
        oldest_s = came_s - len(data) / 67_200
        assert oldest_s == pytest.approx(0.0, abs=0.002)
        assert len(data) > 4595  # and all that waited, so that the next ones are new
        _, came_s = intake.gathered(Wanting())  # type: ignore[arg-type]
        assert came_s == pytest.approx(device.now_s, abs=0.005)


class Scanning(Keeping):
    """The same with a dense scan. It writes down what is recorded."""

    simulated = True

    def __init__(self) -> None:
        super().__init__()
        lidar = S2(lambda angles: np.full(len(angles), 3.0))
        lidar.receive(b"\xa5\x82\x05\x01\x00\x00\x00\x00\x23")
        self._data = lidar.step(2.0)
        self.written: list[tuple[float, int]] = []

    def read(self, timeout_s: float) -> bytes:
        count = len(super().read(timeout_s))
        data, self._data = self._data[:count], self._data[count:]
        return data

    def add(self, time_s: float, nodes: Nodes) -> None:
        self.written.append((time_s, len(nodes)))


def test_nor_does_what_is_recorded_after_one(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Scanning()
    for module in (reader_module, lidar_tools):
        monkeypatch.setattr(module, "time", device)
    device.slept_s = 1.0
    lidar_tools._record(device, "dense", device, 1.5)  # type: ignore[arg-type]
    (first_s, count), *rest = device.written
    assert first_s - count * PERIODS_S["dense"] == pytest.approx(0.0, abs=0.005)
    assert rest[-1][0] == pytest.approx(1.5, abs=0.03)
