"""One lidar's thread with a byte-accurate S2: each way to fail has its reason, and heals."""

from __future__ import annotations

import fcntl
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gazechair.config.configuration import LidarConfig
from gazechair.sensing.lidar import reader as reader_module
from gazechair.sensing.lidar.reader import Reader
from gazelink import codes
from lidarrig import LidarRig, wait_for


class Rig(LidarRig):
    """The lidar, its reader, and every standing that was told."""

    def __init__(self, path: Path, mode: str = "dense") -> None:
        super().__init__(path)
        self.told: list[tuple[str, str]] = []
        config = LidarConfig(kind="s2", port=str(path), mode=mode)
        self.reader = Reader(config, self._note)

    def _note(self) -> None:
        one = (self.reader.standing.state, self.reader.standing.reason)
        if not self.told or self.told[-1] != one:
            self.told.append(one)

    def wait(self, condition: Callable[[], bool]) -> None:
        wait_for(condition, lambda: (self.reader.standing, self.told))

    def wait_fresh(self) -> None:
        """Until there is a scan of what was measured from now on."""
        now_s = time.monotonic()
        self.wait(lambda: (scan := self.reader.scan) is not None and scan.acquired_s > now_s)

    def wait_told(self, reason: str) -> None:
        """Until it is lost for `reason`."""
        self.wait(lambda: ("lost", reason) in self.told)
        self.told.clear()

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
    assert rig.told == [("starting", "lidar_starting"), ("ok", "ok")]
    rig.told.clear()

    beams.frozen = True
    rig.wait_told("lidar_frozen")
    time.sleep(0.8)  # it is started anew, and still repeats itself
    assert rig.reader.scan is None
    assert ("ok", "ok") not in rig.told
    beams.frozen = False
    rig.wait_fresh()

    rig.device.power_dip()
    rig.wait_told("lidar_silent")
    rig.wait_told("lidar_power")
    rig.wait_fresh()

    rig.device.stalled = True
    rig.wait_told("lidar_silent")
    rig.wait(lambda: "no RPLIDAR answers" in rig.reader.standing.detail)
    assert rig.reader.scan is None
    rig.device.stalled = False
    rig.wait_fresh()

    rig.device.mirror_blocked = True
    rig.wait_told("lidar_mirror")
    assert rig.reader.scan is None
    rig.device.mirror_blocked = False
    rig.wait_fresh()

    rig.port.unplug()
    rig.wait_told("lidar_lost")
    assert rig.reader.scan is None
    rig.device.power_on()
    rig.port.plug()
    rig.wait_fresh()

    rig.device.protection_stop = True
    rig.wait_told("lidar_protection")
    rig.device.protection_stop = False
    rig.wait_fresh()
    assert rig.reader.standing.state == "ok"


def test_lost_and_damaged_bytes_are_lived_with(rig: Rig) -> None:
    rig.reader.start()
    rig.wait_fresh()
    rig.told.clear()
    rig.device.drop = rig.device.corrupt = 0.0005
    rig.wait(lambda: rig.reader.stream is not None and rig.reader.stream.resyncs > 20)
    assert set(rig.told) == {("ok", "ok")}
    rig.wait_fresh()
    assert rig.reader.stream is not None
    assert 0.01 < rig.reader.stream.lost_share < 0.2


def test_the_standard_scan_serves_too(tmp_path: Path) -> None:
    rig = Rig(tmp_path / "lidar", "standard")
    try:
        rig.reader.start()
        rig.wait_fresh()
        scan, stream = rig.reader.scan, rig.reader.stream
        assert scan is not None
        assert stream is not None
        assert scan.source == codes.SIMULATED
        assert 1590 <= len(scan) <= 1610
        assert scan.acquired_s <= time.monotonic() - 0.05
        rig.wait(lambda: stream.turns > 5)
        assert 5.0 < stream.rate_hz < 12.0
    finally:
        rig.close()


def test_a_port_that_another_program_holds_is_said(rig: Rig) -> None:
    with rig.port.path.open("rb", buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        rig.reader.start()
        rig.wait(lambda: "used by another program" in rig.reader.standing.detail)
    rig.wait_fresh()


def test_a_port_where_something_else_talks_is_refused_in_one_line(rig: Rig) -> None:
    rig.babble = b"\x55\xaa\x01" * 20
    rig.reader.start()
    rig.wait(lambda: rig.reader.standing.state == "lost")
    assert "lidar.port" in rig.reader.standing.detail
    assert "\n" not in rig.reader.standing.detail
