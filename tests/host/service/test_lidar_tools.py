"""`gazechair lidar mask` and `record`, by the command line, with an emulated S2; and the port."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from serial.tools import list_ports

from gazechair import cli
from gazechair.config import configuration
from gazechair.sensing.lidar import device
from gazechair.sensing.lidar.device import LidarError, find_port
from gazechair.sensing.lidar.scanfile import ScanReader
from lidarrig import LidarRig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[LidarRig]:
    rig = LidarRig(tmp_path / "lidar")
    (tmp_path / "chair.toml").write_text(f'[lidar]\nkind = "s2"\nport = "{rig.path}"\n')
    yield rig
    rig.close()


def test_a_recording_becomes_a_mask(
    rig: LidarRig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    setup, scan = str(tmp_path / "chair.toml"), str(tmp_path / "room.scan")
    assert cli.main(["lidar", "record", scan, "--seconds", "0.8", "--config", setup]) == 0
    assert 'kind = "replay"' in capsys.readouterr().out
    file = ScanReader(Path(scan))
    assert len(list(file.records())) > 10
    assert file.header["mode"] == "dense"
    file.close()
    assert not rig.device.scanning

    assert cli.main(["lidar", "record", scan, "--config", setup]) == 2
    assert "there already" in capsys.readouterr().err

    (tmp_path / "chair.toml").write_text(f'[lidar]\nkind = "replay"\nfile = "{scan}"\n')
    assert cli.main(["lidar", "mask", "--seconds", "5", "--config", setup]) == 0
    printed = capsys.readouterr().out
    assert "the chair itself at 124..-124 degrees" in printed
    line = next(line for line in printed.splitlines() if line.startswith("mask"))
    assert configuration.parse(f"[lidar]\n{line}").lidar[0].mask == ((123.0, -123.0),)


def test_a_mask_that_can_t_be_learned_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "chair.toml").write_text('[lidar]\nkind = "replay"\nfile = "none.scan"\n')
    setup = str(tmp_path / "chair.toml")
    real_s, command = 0.5, "gazechair.service.lidar_tools._PATIENCE_S"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, real_s)
        assert cli.main(["lidar", "mask", "--config", setup]) == 1
    assert "lidar: scan file none.scan can't be read" in capsys.readouterr().out
    assert cli.main(["lidar", "mask"]) == 2
    assert "no lidar is configured" in capsys.readouterr().err
    assert cli.main(["lidar", "record", "x.scan", "--config", setup]) == 2
    assert "say which lidar with --name; there is none" in capsys.readouterr().err


def adapters(*serials: str) -> list[SimpleNamespace]:
    vid, pid = device.USB_IDS
    found = [
        SimpleNamespace(vid=vid, pid=pid, serial_number=serial, device=f"/dev/{serial}")
        for serial in serials
    ]
    return [*found, SimpleNamespace(vid=1, pid=2, serial_number="A", device="/dev/other")]


@pytest.mark.parametrize(
    ("there", "wanted", "found"),
    [
        (("A",), "auto", "/dev/A"),
        (("A", "B"), "usb:B", "/dev/B"),
        (("A",), "/dev/any", "/dev/any"),
        ((), "auto", "no lidar found"),
        (("A", "B"), "auto", "several adapters"),
        (("A", "B"), "usb:C", "there is usb:A, usb:B"),
        ((), "usb:C", "there is none"),
    ],
)
def test_the_port_is_found_or_said(
    there: tuple[str, ...], wanted: str, found: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(list_ports, "comports", lambda: adapters(*there))
    if found.startswith("/dev/"):
        assert find_port(wanted) == found
        return
    with pytest.raises(LidarError, match=found) as refusal:
        find_port(wanted)
    assert refusal.value.reason == "lidar_lost"
