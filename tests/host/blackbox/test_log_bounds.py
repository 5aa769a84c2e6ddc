"""The log stays within its limits, whatever disk and clock do."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gazechair.blackbox import writer as module
from gazechair.blackbox.child import Keeper
from gazechair.blackbox.reader import LogFile
from gazechair.blackbox.ring import Ring
from gazechair.blackbox.writer import FILE_S, LogFull, LogWriter, ages_s, files
from gazereplay.recording import WALL_NS

MB = 10**6


class Disk:
    """A writer with a simulated clock and disk."""

    def __init__(self, folder: Path, max_bytes: int = 100 * MB, keep_s: float = 1e9) -> None:
        self.s = 0.0
        self.wall_s = 0.0
        self.space = 10**10  # of the disk, without others' files
        self.writer = LogWriter(
            folder,
            max_bytes,
            keep_s,
            wall_ns=lambda: WALL_NS + int((self.s + self.wall_s) * 1e9),
            monotonic_ns=lambda: int(self.s * 1e9),
            free_bytes=lambda _: self.space - total(folder),
        )

    def second(self, size: int = 1000) -> None:
        """A second with `size` incompressible bytes."""
        self.s += 1.0
        self.writer.write("picture", int(self.s * 1e9), os.urandom(size))
        self.writer.sync()


def total(folder: Path) -> int:
    return sum(path.stat().st_size for path in files(folder))


def test_the_oldest_go_first_and_the_size_is_never_exceeded(tmp_path: Path) -> None:
    disk = Disk(tmp_path, max_bytes=2 * MB)
    for _ in range(100):
        disk.second(50_000)
        assert total(tmp_path) <= 2 * MB + 55_000
    left = [int(path.name[:6]) for path in files(tmp_path)]
    assert left == list(range(left[0], left[-1] + 1))
    assert left[0] > 5
    assert total(tmp_path) > 1.7 * MB
    assert all(LogFile(path).length_s() >= 0 for path in files(tmp_path))


def test_a_file_is_an_hour(tmp_path: Path) -> None:
    disk = Disk(tmp_path)
    for _ in range(3):
        disk.second()
        disk.s += FILE_S
    assert len(files(tmp_path)) == 2
    disk.writer.close()
    for path in files(tmp_path):
        file = LogFile(path)
        assert [*file.lines()]
        assert file.whole


def test_old_files_go_by_age(tmp_path: Path) -> None:
    disk = Disk(tmp_path, keep_s=86400.0)
    disk.second()
    disk.writer.close()
    (old,) = files(tmp_path)
    now_s = WALL_NS / 1e9 + disk.s
    os.utime(old, (now_s - 86399, now_s - 86399))
    disk.second()
    assert old.exists()
    os.utime(old, (now_s - 86401, now_s - 86401))
    disk.second()
    assert not old.exists()
    assert len(files(tmp_path)) == 1


DAY_S = 86400.0


def log_of_days(folder: Path, days: int) -> None:
    folder.mkdir(exist_ok=True)
    for day in range(days):
        at_s = WALL_NS / 1e9 - (days - day) * DAY_S
        path = folder / f"{day + 1:06}_then.mcap"
        path.write_bytes(b"x")
        os.utime(path, (at_s, at_s))


@pytest.mark.parametrize("jump_s", [30 * DAY_S, 5000 * DAY_S, -20000 * DAY_S])
def test_a_clock_that_is_wrong_deletes_no_log(tmp_path: Path, jump_s: float) -> None:
    """Files of that time neither, once the clock is right again, or after a restart."""
    log_of_days(tmp_path, 10)
    for wrong in (True, True, False, False):
        disk = Disk(tmp_path, keep_s=14 * DAY_S)
        disk.wall_s = jump_s if wrong else 0.0
        disk.writer._clock_is_right = lambda wrong=wrong: not wrong  # type: ignore[misc]
        for _ in range(3):
            disk.second()
        disk.writer.close()
        at_s = WALL_NS / 1e9 + disk.wall_s
        newest = files(tmp_path)[-1]
        os.utime(newest, (at_s, at_s))
    assert len(files(tmp_path)) == 14


def test_files_of_a_wrong_clock_grow_old_too() -> None:
    now_s = WALL_NS / 1e9
    times_s = [now_s - 20 * DAY_S, now_s + 5000 * DAY_S, 60.0, now_s - 15 * DAY_S, now_s - DAY_S]
    trusted = ages_s(times_s, now_s, trusted=True)
    assert trusted == pytest.approx([20 * DAY_S, DAY_S, DAY_S, 15 * DAY_S, DAY_S])
    daily = [now_s - day * DAY_S for day in range(20, 0, -1)]
    assert ages_s(daily, now_s, trusted=False) == pytest.approx(ages_s(daily, now_s, trusted=True))


def test_a_clock_that_is_set_begins_a_file_and_the_order_stays(tmp_path: Path) -> None:
    disk = Disk(tmp_path)
    disk.second()
    disk.wall_s = -1e9  # as after a start without a clock's battery
    disk.second()
    disk.second()
    disk.second()
    assert [path.name[:6] for path in files(tmp_path)] == ["000001", "000002"]
    times = [line.at_ns for line in LogFile(files(tmp_path)[1]).lines()]
    assert all(abs(at_ns - WALL_NS + 1e18) < 100e9 for at_ns in times)


def test_a_clock_that_is_set_all_the_time_makes_a_file_a_minute(tmp_path: Path) -> None:
    """As with two time servers that disagree: many small files would displace the old ones."""
    disk = Disk(tmp_path)
    for _ in range(300):
        disk.wall_s = 1e7 - disk.wall_s
        disk.second()
    assert 3 <= len(files(tmp_path)) <= 6
    lines = [line for path in files(tmp_path) for line in LogFile(path).lines()]
    assert len(lines) == 300


def test_a_disk_that_others_fill_gets_the_oldest_then_nothing_is_written(tmp_path: Path) -> None:
    disk = Disk(tmp_path)
    for _ in range(3):
        disk.second(10_000)
        disk.writer.close()
    disk.space = (100 << 20) + 30_000  # the 100 MB stay free
    disk.second()
    assert [path.name[:6] for path in files(tmp_path)] == ["000002", "000003", "000004"]
    disk.space = 1000
    with pytest.raises(LogFull):
        disk.second()
    disk.writer.close()
    with pytest.raises(LogFull):
        disk.second()
    assert len(files(tmp_path)) <= 1


def test_many_small_files_are_bounded_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a host that restarts again and again."""
    monkeypatch.setattr(module, "_MOST_FILES", 5)
    for _ in range(9):
        disk = Disk(tmp_path)
        disk.second()
        disk.writer.close()
    names = [path.name[:6] for path in files(tmp_path)]
    assert names == ["000005", "000006", "000007", "000008", "000009"]


def test_a_disk_that_refuses_for_hours_costs_no_older_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with a quota: there is space, each attempt opens a file, and nothing gets into it."""
    monkeypatch.setattr(module, "_MOST_FILES", 5)
    for _ in range(3):
        disk = Disk(tmp_path)
        disk.second()
        disk.writer.close()

    def refused(_: int) -> None:
        raise OSError(errno.EDQUOT, os.strerror(errno.EDQUOT))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", refused)
        for _ in range(9):
            with pytest.raises(OSError, match="quota"):
                disk.second()
            disk.writer.close()
    disk.second()
    disk.writer.close()
    assert [path.name[:6] for path in files(tmp_path)] == ["000001", "000002", "000003", "000004"]


def test_a_log_of_a_clock_beyond_2038_has_its_length_and_date(tmp_path: Path) -> None:
    disk = Disk(tmp_path)
    disk.wall_s = 20 * 365.25 * DAY_S
    for _ in range(5):
        disk.second()
    disk.writer.close()
    (file,) = map(LogFile, files(tmp_path))
    assert file.length_s() == pytest.approx(4.0)
    at_s = next(file.lines()).at_ns / 1e9
    assert at_s == pytest.approx(WALL_NS / 1e9 + disk.wall_s, abs=2.0)


def test_a_file_that_somebody_deletes_is_followed_by_another(tmp_path: Path) -> None:
    disk = Disk(tmp_path)
    disk.second()
    for path in files(tmp_path):
        path.unlink()
    disk.second()
    disk.second()
    (path,) = files(tmp_path)
    assert len([*LogFile(path).lines()]) == 1
    path.unlink()
    tmp_path.rmdir()
    disk.second()
    disk.second()
    assert len(files(tmp_path)) == 1


def test_only_its_user_may_read_the_log(tmp_path: Path) -> None:
    disk = Disk(tmp_path / "log")
    disk.second()
    (path,) = files(tmp_path / "log")
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700


def test_files_of_others_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.mcap").write_bytes(bytes(3 * MB))
    disk = Disk(tmp_path, max_bytes=1 * MB)
    for _ in range(30):
        disk.second(50_000)
    assert (tmp_path / "notes.mcap").exists()


class Out:
    """Records the messages of the log's process to the daemon."""

    def __init__(self) -> None:
        self.statuses: list[tuple[str, str, str]] = []
        self.data_count = 0

    def status(self, *status: str) -> None:
        self.statuses.append(status)  # type: ignore[arg-type]

    def data(self, _payload: bytes) -> None:
        self.data_count += 1


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    now = SimpleNamespace(s=100.0)
    monkeypatch.setattr("gazechair.blackbox.child.time.monotonic", lambda: now.s)
    return now


class Sent:
    """A line that keeps what it receives, or blocks."""

    def __init__(self) -> None:
        self.batches: list[bytes] = []
        self.full = False

    def send(self, batch: bytes) -> None:
        if self.full:
            raise BlockingIOError
        self.batches.append(batch)


def batch(count: int) -> bytes:
    ring, line = Ring(), Sent()
    for at in range(count):
        ring.put("line", at, (20, "gazechair", "text"))
    ring.hand_over(line)  # type: ignore[arg-type]
    (only,) = line.batches
    return only


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO, errno.EROFS])
@pytest.mark.parametrize("where", ["_open", "fsync"])
def test_a_disk_that_refuses_is_told_and_tried_again(
    tmp_path: Path, clock: Any, monkeypatch: pytest.MonkeyPatch, error: int, where: str
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(error, os.strerror(error))

    out = Out()
    keeper = Keeper(LogWriter(tmp_path, MB, 1e9, free_bytes=lambda _: 10**10), out)  # type: ignore[arg-type]
    with monkeypatch.context() as patch:
        if where == "fsync":
            patch.setattr(module.os, "fsync", refuse)
        else:
            patch.setattr(module.LogWriter, "_open", refuse)
        for _ in range(5):
            keeper.take(batch(3))
            clock.s += 1.0
            keeper.due()
        assert out.statuses[-1][:2] == (
            "degraded",
            "log_full" if error == errno.ENOSPC else "log_disk",
        )
        assert len(out.statuses) <= 2
        assert out.data_count == 5  # alive all the while
        assert keeper.lost >= 9
    clock.s += 10.0
    keeper.take(batch(3))
    clock.s += 1.0
    keeper.due()
    assert out.statuses[-1][0] == "ok"
    lines = [line.topic for path in files(tmp_path) for line in LogFile(path).lines()]
    assert lines[-3:] == ["/rosout"] * 3


def test_a_hanging_disk_drops_and_counts_and_nobody_waits() -> None:
    """Ten seconds of driving are queued; later records are dropped, the oldest kept."""
    ring, line = Ring(), Sent()
    line.full = True
    per_s = 210
    for at in range(10 * per_s):
        ring.put("up", at / per_s, b"frame")
        if at % 20 == 0:
            ring.hand_over(line)  # type: ignore[arg-type]
    assert ring.dropped == 0
    for at in range(10 * per_s, 60 * per_s):
        ring.put("up", at / per_s, b"frame")
    assert ring.dropped == 60 * per_s - len(ring)
    line.full = False
    ring.hand_over(line)  # type: ignore[arg-type]
    assert len(ring) == 0
    ring.put("up", 61, b"frame")
    ring.hand_over(line)  # type: ignore[arg-type]


def test_a_record_that_is_too_long_holds_up_no_other() -> None:
    ring, line = Ring(), Sent()
    for size in (10, 60_000, 60_000, 60_000, 1 << 20, 10):
        ring.put("picture", 0.0, bytes(size))
    ring.hand_over(line)  # type: ignore[arg-type]
    assert ring.dropped == 1
    assert max(len(one) for one in line.batches) <= 1 << 17
    assert sum(len(one) for one in line.batches) > 180_000


def test_what_cannot_be_packed_or_sent_is_dropped_and_counted() -> None:
    ring, line = Ring(), Sent()
    ring.put("line", 0.0, object())  # a mistake of ours must not end the recording
    ring.hand_over(line)  # type: ignore[arg-type]
    assert (ring.dropped, len(ring), line.batches) == (1, 0, [])

    def refuse(_: bytes) -> None:
        raise OSError(errno.EMSGSIZE, "Message too long")

    line.send = refuse  # type: ignore[method-assign]
    ring.put("line", 0.0, (20, "gazechair", "text"))
    ring.hand_over(line)  # type: ignore[arg-type]
    assert (ring.dropped, len(ring)) == (2, 0)
