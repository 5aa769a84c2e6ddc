"""Files that a person may edit or hand over, with a byte order mark, or nested without end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gazechair.alerts.diary import Diary
from gazechair.base import json_text
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config import configuration
from gazechair.config.settings import Config
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.first_drive.record import Record
from gazechair.people.pairing.store import DeviceStore
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.floor_store import FloorStore
from gazechair.plugins import exchange
from gazechair.sensing.inbox import inbox
from gazechair.sensing.lidar.scanfile import _MAGIC as SCANS
from gazechair.sensing.lidar.scanfile import ScanFileError, ScanReader
from gazechair.sensing.mapping.stored import ros_map
from gazechair.service.calibrate.camera import _marks
from gazelink.settings_table import PROFILES
from storedmaps import home

MARK = b"\xef\xbb\xbf"
DEEP = b"[" * 100_000


def profile(folder: Path) -> Any:
    return Profiles(folder, house_fields(Config())).chosen()["dwell_ms"]


def device(folder: Path) -> Any:
    return [one.name for one in DeviceStore(folder).all()]


def kept(folder: Path) -> None:
    """Every file of the state folder that is text."""
    Profiles(folder, house_fields(Config())).change({"save": {"id": "1", "dwell_ms": 700}}, True)
    DeviceStore(folder).add("driver", "tablet", 1)
    Record(folder).keep("relay", True)
    cap = SpeedCapStore(folder)
    cap.keep(500)
    cap.write()
    Diary(folder).write([{"number": 1, "state": "open"}])
    ForwardStore(folder).keep(PROFILES[0], ForwardNumbers(1.0, 0.1, 0.1, 0.1, 1.0, 1.0))


STATE: dict[str, Callable[[Path], Any]] = {
    "profiles.json": profile,
    "paired.jsonl": device,
    "first_drive.json": lambda folder: Record(folder).get("relay"),
    "speed_cap": lambda folder: SpeedCapStore(folder).read(),
    "alerts.jsonl": lambda folder: Diary(folder).read(),
    "forward.json": lambda folder: ForwardStore(folder).step_ms(0, 500, 100),
}


@pytest.mark.parametrize("name", STATE)
def test_a_state_file_that_was_edited_on_windows_is_read_as_before(
    tmp_path: Path, name: str
) -> None:
    kept(tmp_path)
    before = STATE[name](tmp_path)
    file = tmp_path / name
    file.write_bytes(MARK + file.read_bytes().replace(b"\n", b"\r\n"))
    assert STATE[name](tmp_path) == before is not None


@pytest.mark.parametrize("name", STATE)
def test_a_state_file_nested_without_end_is_kept_aside_or_as_it_is(
    tmp_path: Path, name: str
) -> None:
    kept(tmp_path)
    before = STATE[name](tmp_path)
    (tmp_path / name).write_bytes(DEEP)
    assert STATE[name](tmp_path) != before
    contents = [file.read_bytes() for file in tmp_path.glob(f"{name.partition('.')[0]}.*")]
    assert DEEP in [*contents, (tmp_path / "speed_cap").read_bytes()]


def test_a_configuration_that_was_edited_on_windows(tmp_path: Path) -> None:
    file = tmp_path / "chair.toml"
    file.write_bytes(MARK + b'[web]\r\nlanguage = "en"\r\n')
    assert configuration.load(file).web.language == "en"
    file.write_bytes(MARK + b"[web]\r\nlanguage = 7\r\n")
    with pytest.raises(configuration.ConfigError, match=r"chair\.toml:2: web\.language"):
        configuration.load(file)


def test_marks_of_the_camera_that_were_edited_on_windows(tmp_path: Path) -> None:
    file = tmp_path / "marks.txt"
    file.write_bytes(MARK + b"320 240 1.0 0.5\r\n")
    assert len(_marks(file)) == 1


def test_a_calibration_of_the_camera_nested_without_end(tmp_path: Path) -> None:
    (tmp_path / "camera_floor.json").write_bytes(DEEP)
    assert FloorStore(tmp_path).get() is None


def test_a_scan_file_whose_header_is_nested_without_end(tmp_path: Path) -> None:
    file = tmp_path / "scans"
    for header in (b"[" * 4000, b'{"period_s": 1' + b"0" * 400 + b"}"):
        file.write_bytes(SCANS + header + b"\n")
        with pytest.raises(ScanFileError, match="its header is damaged"):
            ScanReader(file)


@pytest.mark.parametrize("whole", [True, False])
def test_places_of_an_uploaded_map(tmp_path: Path, whole: bool) -> None:
    ros_map.write(home(), tmp_path)
    places = tmp_path / ros_map.PLACES
    places.write_bytes(MARK + places.read_bytes() if whole else DEEP)
    if whole:
        assert ros_map.read(tmp_path / "map.yaml", "home").drawn == home().drawn
        return
    with pytest.raises(ros_map.RosMapError, match="nested too deeply"):
        ros_map.read(tmp_path / "map.yaml", "home")


def test_messages_of_other_processes_nested_without_end() -> None:
    assert inbox.unpack(b"E" + DEEP) is None
    for unpack in (exchange.unpack, exchange.unpack_facts):
        with pytest.raises(exchange.BadValue):
            unpack(DEEP)


def test_json_is_a_value_or_a_value_error() -> None:
    assert json_text.parse(b'\xef\xbb\xbf{"a": 1}') == json_text.parse('\ufeff{"a": 1}') == {"a": 1}
    for bad in (DEEP, DEEP.decode(), b"\xff", "\ufeff\ufeff1", ""):
        with pytest.raises(ValueError, match=r"JSON|utf|Expecting|BOM|nested"):
            json_text.parse(bad)
