"""Power cuts at random bytes of the log, and of each file of the state folder."""

from __future__ import annotations

import os
import random
import resource
import signal
import tempfile
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from gazechair.alerts.book import Book
from gazechair.alerts.diary import FILE_NAME as DIARY
from gazechair.alerts.diary import Diary
from gazechair.alerts.reasons import HELP_WANTED
from gazechair.blackbox.reader import LogFile
from gazechair.config.configuration import Config
from gazechair.driving.speed_cap_store import FILE_NAME as SPEED_CAP
from gazechair.driving.speed_cap_store import KeptCap
from gazechair.first_drive.record import FILE_NAME as FIRST_DRIVE
from gazechair.first_drive.record import Record
from gazechair.people.pairing.store import FILE_NAME as PAIRED
from gazechair.people.pairing.store import DeviceStore
from gazechair.people.profiles import Profiles, house_fields
from gazechair.people.profiles.store import FILE_NAME as PROFILES
from gazemeasure.allday_chair import DayChair
from gazemeasure.report import Report
from gazereplay.recording import WALL_NS

_SYNC_MS = 1000.0


@dataclass(frozen=True)
class Store:
    """A file of the state folder."""

    file: str
    write: Callable[[Path, int], None]
    """Write the version of that number, 1 or 2."""
    read: Callable[[Path], Any]
    """The content that a newly started host finds."""


def _folder() -> tempfile.TemporaryDirectory[str]:
    # In memory if possible: syncing a real disk is slow.
    memory = Path("/dev/shm")
    return tempfile.TemporaryDirectory(
        prefix="gazechair-", dir=memory if os.access(memory, os.W_OK) else None
    )


def _profiles(folder: Path) -> Profiles:
    return Profiles(folder, house_fields(Config()))


def _write_profile(folder: Path, number: int) -> None:
    _profiles(folder).change({"save": {"id": "1", "dwell_ms": 500 + 100 * number}}, True)


def _keep_cap(folder: Path, number: int) -> None:
    kept = KeptCap(folder)
    kept.keep(500 * number)
    kept.write()


def _pair(folder: Path, number: int) -> None:
    DeviceStore(folder).add("driver", f"tablet {number}", 1)


def _write_diary(folder: Path, number: int) -> None:
    book = Book([])
    for _ in range(number):
        book.raise_(HELP_WANTED, 0.0, 1e9, "Ik zit vast in het park")
        book.end(HELP_WANTED, -1e9)
    Diary(folder).write(book.as_json())


STORES = (
    Store(SPEED_CAP, _keep_cap, lambda at: KeptCap(at).read()),
    Store(PROFILES, _write_profile, lambda at: _profiles(at).chosen()["dwell_ms"]),
    Store(
        PAIRED,
        _pair,
        lambda at: [device.name for device in DeviceStore(at).all()],
    ),
    Store(
        FIRST_DRIVE,
        lambda at, n: Record(at).keep("distance", n),
        lambda at: Record(at).get("distance"),
    ),
    Store(DIARY, _write_diary, lambda at: len(Diary(at).read())),
)


@dataclass
class Cuts:
    """The results of a store's cuts."""

    half: int = 0
    """Cuts after which neither the old nor the new settings were found."""
    dead: list[str] = field(default_factory=list)
    """Files with which a host would not start, or which it could not write again."""


def cut_writing(store: Store, cuts: int, dice: random.Random) -> Cuts:
    """The process is killed, or the disk full, at a random byte of the second version."""
    found = Cuts()
    with _folder() as name:
        home = Path(name)
        store.write(home, 1)
        content = (home / store.file).read_bytes()
        old = store.read(home)
        store.write(home, 2)
        new, most = store.read(home), (home / store.file).stat().st_size
        for number in range(cuts):
            (home / store.file).write_bytes(content)
            _write_until(store, home, dice.randrange(most + 1), full=number % 2 == 1)
            try:
                found.half += store.read(home) not in (old, new)
            except Exception as error:  # of any kind: a host would not start
                found.dead.append(f"{store.file}: {error!r}")
        store.write(home, 2)
        found.half += store.read(home) != new and store.file != PAIRED
    return found


def _write_until(store: Store, home: Path, size: int, full: bool) -> None:
    """Write in a process that is killed at byte `size`, or whose disk is then `full`."""
    child = os.fork()
    if child:
        os.waitpid(child, 0)
        return
    try:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN if full else signal.SIG_DFL)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        store.write(home, 2)
    finally:
        os._exit(0)


def cut_file(store: Store, cuts: int, dice: random.Random) -> Cuts:
    """A disk that loses data: the file itself is truncated at a random byte."""
    found = Cuts()
    with _folder() as name:
        home = Path(name)
        store.write(home, 1)
        content = (home / store.file).read_bytes()
        for _ in range(cuts):
            (home / store.file).write_bytes(content[: dice.randrange(len(content))])
            try:
                store.read(home)
                store.write(home, 2)
            except Exception as error:
                found.dead.append(f"{store.file}: {error!r}")
    return found


def unsynced(store: Store) -> int:
    """How often it is replaced without a sync of the new file and of the folder."""
    order: list[str] = []
    fsync, replace = os.fsync, os.replace

    def note_fsync(handle: int) -> None:
        order.append(f"sync {os.readlink(f'/proc/self/fd/{handle}')}")
        fsync(handle)

    def note_replace(old: Any, new: Any) -> None:
        order.append(f"replace {old}")
        replace(old, new)

    with _folder() as name:
        with mock.patch("os.fsync", note_fsync), mock.patch("os.replace", note_replace):
            store.write(Path(name), 1)
        missed = 0
        for at, act in enumerate(order):
            if act.startswith("replace "):
                missed += f"sync {act.partition(' ')[2]}" not in order[:at]
                missed += f"sync {name}" not in order[at:]
        return missed + (not any(act.startswith("replace ") for act in order))


def cut_log(cuts: int, dice: random.Random) -> tuple[int, float]:
    """Truncate a drive's log at random bytes: number unreadable, and the most ms lost."""
    with _folder() as name:
        chair = DayChair(Path(name), record=True)
        chair.arm()
        for verb in ("forward", "left"):
            chair.moves_after(k="cmd", verb=verb, mode="continuous")
            chair.run(2000)
            chair.driver.release()
            chair.run(1000)
        synced = [(0, 0), *sorted((size, ms) for ms, size in chair.synced.items())]
        path = chair.close()
        whole, times = path.read_bytes(), _times_ms(path)
        unreadable, worst_ms = 0, 0.0
        for _ in range(cuts):
            cut = dice.randrange(synced[1][0], len(whole))
            path.write_bytes(whole[:cut])
            try:
                read = len(_times_ms(path))
            except Exception:
                unreadable += 1
                continue
            k = bisect_right([size for size, _ in synced], cut) - 1
            gone_ms = synced[k + 1][1] if k + 1 < len(synced) else times[-1]
            kept = bisect_right(times, synced[k][1])
            lost_ms = gone_ms - (synced[k][1] if read >= kept else times[read])
            worst_ms = max(worst_ms, lost_ms)
    return unreadable, worst_ms


def _times_ms(path: Path) -> list[int]:
    return [round((line.at_ns - WALL_NS) / 1e6) for line in LogFile(path).lines()]


def add(report: Report, cuts: int) -> None:
    """Measure `cuts` cuts of each file."""
    dice = random.Random(14)
    unreadable, lost_ms = cut_log(cuts, dice)
    report.add(f"power cut at {cuts} bytes of the log: unreadable", unreadable, "", 0)
    report.add("  lost at most", lost_ms, "ms", _SYNC_MS)
    for store in STORES:
        writing, file = cut_writing(store, cuts, dice), cut_file(store, cuts, dice)
        dead = writing.dead + file.dead
        report.add(f"power cut at {cuts} bytes of {store.file}: half", writing.half, "", 0)
        report.add("  a host would not start or write", len(dead), "", 0)
        report.add("  replaced before it is on the disk", unsynced(store), "", 0)
        for line in dead[:2]:
            report.note(line)
