"""Recorded scans: measurements are replayed at their own times; damage is refused with reasons."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar.nodes import Nodes, our_angle
from gazechair.sensing.lidar.reader import Reader
from gazechair.sensing.lidar.scanfile import ScanFileError, ScanReader, ScanWriter
from gazelink import codes
from lidarrig import wait_for

PERIOD_S = 1.0 / 32_000.0
PIECE = 800  # a quarter turn


def piece(number: int) -> Nodes:
    index = np.arange(number * PIECE, (number + 1) * PIECE)
    raw_deg = index % 3200 * 0.1125
    random = np.random.default_rng(number)
    return Nodes(
        angles_deg=our_angle(raw_deg),
        distances_m=np.round(random.uniform(0.0, 30.0, PIECE), 3),
        starts=(index % 3200 == 0) & (number > 0),
        backlog=np.arange(PIECE - 1, -1, -1),
    )


def write(path: Path, pieces: int) -> None:
    writer = ScanWriter(path, {"period_s": PERIOD_S, "name": "front"})
    for number in range(pieces):
        writer.add(0.025 * (number + 1), piece(number))
    writer.close()


def read(path: Path) -> list[tuple[float, Nodes]]:
    file = ScanReader(path)
    try:
        return list(file.records())
    finally:
        file.close()


def test_it_comes_back_as_it_was(tmp_path: Path) -> None:
    write(tmp_path / "a.scan", 12)
    records = read(tmp_path / "a.scan")
    assert [time_s for time_s, _ in records] == pytest.approx([0.025 * n for n in range(1, 13)])
    for number, (_, nodes) in enumerate(records):
        true = piece(number)
        turned = (nodes.angles_deg - true.angles_deg + 180.0) % 360.0 - 180.0
        assert np.abs(turned).max() <= 1.0 / 128.0 + 1e-9
        assert np.allclose(nodes.distances_m, true.distances_m)
        assert np.array_equal(nodes.starts, true.starts)


def test_it_is_compact(tmp_path: Path) -> None:
    write(tmp_path / "a.scan", 40)
    # Of these distances, which are noise alone, nothing can be saved: 2 bytes each.
    assert (tmp_path / "a.scan").stat().st_size < 40 * PIECE * 2.2


def test_a_file_cut_off_by_a_power_cut_is_read_up_to_there(tmp_path: Path) -> None:
    write(tmp_path / "a.scan", 6)
    whole = (tmp_path / "a.scan").read_bytes()
    (tmp_path / "b.scan").write_bytes(whole[:-100])
    assert len(read(tmp_path / "b.scan")) == 5


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("scan") / "a.scan"
    write(path, 3)
    return path.read_bytes()


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_any_damage_is_refused_in_one_line_or_shortens_it(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    at = data.draw(st.integers(0, len(whole) - 1))
    flip = data.draw(st.integers(1, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.scan"
    path.write_bytes(whole[:at] + bytes((whole[at] ^ flip,)) + whole[at + 1 :])
    reason, records = "", []
    try:
        records = read(path)
    except ScanFileError as error:
        reason = str(error)
    assert "\n" not in reason
    # The header is for people but for one number; a length beyond the end is a cut-off file.
    assert reason or len(records) < 3 or at < whole.index(b"\n", 20) + 1


REFUSED: list[tuple[Callable[[bytes], bytes], str]] = [
    (lambda whole: b"", "is no scan file"),
    (lambda whole: b"\x00" * 500, "is no scan file"),
    (lambda whole: whole[:17] + b"{}\n" + whole[17:], "header is damaged"),
    (lambda whole: whole[: whole.index(b"\n", 20) + 1], "holds no measurements"),
    (lambda whole: whole[:300] + b"x" + whole[301:], "wrong checksum"),
    (lambda whole: whole + whole[whole.index(b"\n", 20) + 1 :], "times out of order"),
]


@pytest.mark.parametrize(("change", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_refusals_say_why(
    whole: bytes, tmp_path: Path, change: Callable[[bytes], bytes], words: str
) -> None:
    path = tmp_path / "a.scan"
    path.write_bytes(change(whole))
    with pytest.raises(ScanFileError, match=words):
        ScanReader(path)


def test_a_missing_file_and_one_that_is_there(tmp_path: Path) -> None:
    with pytest.raises(ScanFileError, match=r"can't be read"):
        ScanReader(tmp_path / "none.scan")
    write(tmp_path / "a.scan", 1)
    with pytest.raises(ScanFileError, match="there already"):
        ScanWriter(tmp_path / "a.scan", {})


def test_it_is_played_as_a_lidar_again_and_again_and_marked(tmp_path: Path) -> None:
    write(tmp_path / "a.scan", 14)  # three and a half turns: 0.35 s
    reader = Reader(LidarConfig(kind="replay", file=str(tmp_path / "a.scan")), lambda: None)
    start_s = time.monotonic()
    reader.start()
    try:
        wait_for(lambda: reader.scan is not None, lambda: reader.condition)
        assert reader.scan is not None
        assert reader.scan.source == codes.REPLAYED
        assert 3200 <= len(reader.scan) <= 3201
        later_s = start_s + 0.8  # after its end: it began again
        wait_for(lambda: reader.scan.acquired_s > later_s, lambda: reader.condition)
        assert reader.condition.state == "ok"
    finally:
        reader.stop()


def test_a_damaged_recording_is_a_lost_lidar_with_the_reason(tmp_path: Path) -> None:
    write(tmp_path / "a.scan", 14)
    damaged = bytearray((tmp_path / "a.scan").read_bytes())
    damaged[5000] ^= 1
    (tmp_path / "a.scan").write_bytes(damaged)
    reader = Reader(LidarConfig(kind="replay", file=str(tmp_path / "a.scan")), lambda: None)
    reader.start()
    try:
        wait_for(lambda: reader.condition.state == "lost", lambda: reader.condition)
        assert "wrong checksum" in reader.condition.detail
        assert reader.scan is None
    finally:
        reader.stop()
