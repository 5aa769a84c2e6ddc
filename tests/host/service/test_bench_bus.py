"""The Linux I2C bus: refusals in one plain line, and transfers as smbus2 requires them."""

import errno
import os
import pwd
from pathlib import Path
from typing import Any

import pytest

from gazechair.service.bench import BenchError
from gazechair.service.bench.bus import BusioShape, LinuxBus

smbus2 = pytest.importorskip("smbus2", reason="needs the extra bench: pip install gazechair[bench]")


def refusal(error: OSError, devices: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    def refuse(_path: str) -> Any:
        raise error

    monkeypatch.setattr(smbus2, "SMBus", refuse)
    with pytest.raises(BenchError) as caught:
        LinuxBus(7, devices)
    return str(caught.value)


def test_a_bus_that_is_not_there_lists_those_that_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = OSError(errno.ENOENT, "No such file or directory")
    assert "sudo modprobe i2c-dev" in refusal(gone, tmp_path, monkeypatch)
    for number in (10, 2):
        (tmp_path / f"i2c-{number}").touch()
    assert "the buses here are 2, 10" in refusal(gone, tmp_path, monkeypatch)


def test_no_permission_names_group_and_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one it runs as: under sudo, the package's command runs as the service's."""
    monkeypatch.setenv("USER", "somebody-else")
    printed = refusal(OSError(errno.EACCES, "Permission denied"), tmp_path, monkeypatch)
    assert f"usermod -aG i2c {pwd.getpwuid(os.geteuid()).pw_name}`" in printed


def test_transfers_go_out_as_messages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sent = []

    class Opened:
        def __init__(self, path: str) -> None:
            assert path == str(tmp_path / "i2c-7")

        def i2c_rdwr(self, *messages: Any) -> None:
            sent.append([(m.addr, m.flags & 1, bytes(m)) for m in messages])

        def close(self) -> None:
            sent.append("closed")

    monkeypatch.setattr(smbus2, "SMBus", Opened)
    bus = LinuxBus(7, tmp_path)
    bus.write(0x2C, b"\x80\xaa")
    assert bus.read(0x2C, 1) == b"\0"
    assert bus.write_read(0x28, b"\x00", 2) == b"\0\0"
    bus.close()
    assert sent == [
        [(0x2C, 0, b"\x80\xaa")],
        [(0x2C, 1, b"\0")],
        [(0x28, 0, b"\0"), (0x28, 1, b"\0\0")],
        "closed",
    ]


def test_the_shape_adafruit_expects_honours_start_and_end() -> None:
    class Recorder:
        def __init__(self) -> None:
            self.written: list[bytes] = []

        def write(self, address: int, data: bytes) -> None:
            self.written.append(data)

        def read(self, address: int, count: int) -> bytes:
            return bytes(range(1, count + 1))

        def write_read(self, address: int, data: bytes, count: int) -> bytes:
            self.write(address, data)
            return self.read(address, count)

        def close(self) -> None:
            pass

    recorder = Recorder()
    shape = BusioShape(recorder)
    assert shape.try_lock()
    shape.writeto(0x28, b"abcd", start=1, end=3)
    buffer = bytearray(4)
    shape.readfrom_into(0x28, buffer, start=2)
    assert buffer == b"\0\0\x01\x02"
    shape.writeto_then_readfrom(0x28, buffer, buffer, out_end=1, in_start=1)
    assert buffer == b"\0\x01\x02\x03"
    assert recorder.written == [b"bc", b"\0"]
