"""Power cut at any byte: no file is unreadable, and at most a second of it is lost."""

from __future__ import annotations

import random
import time
from bisect import bisect_right
from itertools import pairwise
from pathlib import Path

import pytest

from gazechair.blackbox.reader import LogFile
from gazechair.blackbox.writer import LogWriter
from gazereplay.recording import WALL_NS
from recordedchair import RecordedChair

CUTS = 250  # besides those around every sync


def times_ms(path: Path) -> list[int]:
    return [round((line.at_ns - WALL_NS) / 1e6) for line in LogFile(path).lines()]


def test_cut_at_random_bytes(drive: RecordedChair, recorded: Path, tmp_path: Path) -> None:
    """What was synced before the byte was written is read, to the last message."""
    whole = recorded.read_bytes()
    times = times_ms(recorded)
    synced = [(0, -1), *sorted((size, ms) for ms, size in drive.sizes.items())]
    sizes = [size for size, _ in synced]
    cut_file = tmp_path / "cut.mcap"
    dice = random.Random(14)
    around = [size + off for size in sizes[1:] for off in (-1, 0, 1) if size + off < len(whole)]
    for cut in [0, 1, 8, 30, *around, *(dice.randrange(len(whole)) for _ in range(CUTS))]:
        cut_file.write_bytes(whole[:cut])
        file = LogFile(cut_file)
        read = sum(1 for _ in file.lines())
        assert not file.whole
        synced_ms = synced[bisect_right(sizes, cut) - 1][1]
        assert read >= bisect_right(times, synced_ms), f"cut at byte {cut}"
        assert read <= bisect_right(times, synced_ms + 1000)


def test_a_short_file_cut_at_every_byte_has_a_length(tmp_path: Path) -> None:
    writer = LogWriter(tmp_path / "log", 10**9, 10**9)
    writer.write("health", time.monotonic_ns(), [("board", "ok", "ok", "")])
    path = writer.path
    assert path is not None
    writer.close()
    whole = path.read_bytes()
    for cut in range(len(whole)):
        path.write_bytes(whole[:cut])
        file = LogFile(path)
        assert (file.length_s(), file.whole) == (0.0, False), f"cut at byte {cut}"


def test_syncs_are_a_second_apart(drive: RecordedChair) -> None:
    ms = sorted(drive.sizes)
    assert max(b - a for a, b in pairwise(ms)) == 1000


@pytest.mark.parametrize("at", [0.1, 0.5, 0.9])
def test_a_damaged_byte_ends_the_file_there(recorded: Path, tmp_path: Path, at: float) -> None:
    data = bytearray(recorded.read_bytes())
    data[int(len(data) * at)] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    read = times_ms(damaged)
    assert read == times_ms(recorded)[: len(read)]
    assert 0 <= LogFile(damaged).length_s() <= LogFile(recorded).length_s()


def test_a_file_that_is_none(tmp_path: Path) -> None:
    file = tmp_path / "none.mcap"
    for content in (b"", b"{}", bytes(1000), b"\x89MCAP0\r\n" + b"\xff" * 100):
        file.write_bytes(content)
        assert not [*LogFile(file).lines()]
        assert LogFile(file).length_s() == 0.0
