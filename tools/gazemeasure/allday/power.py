"""Power cuts at random bytes of the log, and of each file of the state folder."""

from __future__ import annotations

import os
import random
import resource
import signal
import ssl
import tempfile
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from gazechair.alerts.book import Book
from gazechair.alerts.diary import FILE_NAME as DIARY
from gazechair.alerts.diary import Diary
from gazechair.alerts.reasons import HELP_WANTED
from gazechair.blackbox.reader import LogFile
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazechair.commissioning.tune.forward_store import FILE_NAME as FORWARD
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config.settings import Config
from gazechair.driving.messages import LOWEST_CAP_PERMILLE
from gazechair.driving.speed_cap_store import FILE_NAME as SPEED_CAP
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.first_drive.record import FILE_NAME as FIRST_DRIVE
from gazechair.first_drive.record import Record
from gazechair.people.pairing.store import FILE_NAME as PAIRED
from gazechair.people.pairing.store import DeviceStore
from gazechair.people.profiles import Profiles, house_fields
from gazechair.people.profiles.store import FILE_NAME as PROFILES
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FILE_NAME as CAMERA_FLOOR
from gazechair.picture.floor_store import FloorStore
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import FOLDER as MAPS
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.mapping.upkeep import Ledger, load_ledger
from gazechair.web.certificate import Certificate
from gazelink.settings_table import PROFILES as MOTION_PROFILES
from gazemeasure.allday.chair import DayChair
from gazemeasure.report import Report
from gazereplay.recording import WALL_NS

_SYNC_MS = 1000.0
_MOST_CERTIFICATES = 100  # each takes three runs of openssl
_GRID = OccupancyGrid(0.05, np.zeros(2), *np.indices((40, 30), dtype=np.uint16))


@dataclass(frozen=True)
class Store:
    """A file of the state folder."""

    file: str
    write: Callable[[Path, int], None]
    """Write the version of that number, 1 or 2."""
    read: Callable[[Path], Any]
    """The content that a newly started host finds."""
    damaged: Any = None
    """What a damaged file counts as, where that is not the same as none."""


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
    kept = SpeedCapStore(folder)
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


def _write_forward(folder: Path, number: int) -> None:
    numbers = ForwardNumbers(0.5 + 0.1 * number, 0.1, 0.1, 0.2, 0.5, 0.5)
    ForwardStore(folder).keep(MOTION_PROFILES[0], numbers)


def _write_floor(folder: Path, number: int) -> None:
    camera = FloorCamera(640, 480, 500.0, 1.0 + 0.1 * number, 0.5)
    FloorStore(folder).keep(Calibration(camera, 0.01, 0.01))


def _write_map(folder: Path, number: int) -> None:
    HomeMap(f"Thuis {number}", _GRID).save(folder / MAPS / "a.map")


def _read_map(folder: Path) -> str | None:
    found = MapStore(folder / MAPS).get("a")
    return found.map.name if found is not None and found.map is not None else None


def _ledger(folder: Path) -> Path:
    return folder / MAPS / "drives" / "a"


def _write_ledger(folder: Path, number: int) -> None:
    replace(Ledger.of(_GRID), drive_s=float(number)).save(_ledger(folder))


STORES = (
    Store(SPEED_CAP, _keep_cap, lambda at: SpeedCapStore(at).read(), LOWEST_CAP_PERMILLE),
    Store(PROFILES, _write_profile, lambda at: _profiles(at).chosen()["dwell_ms"]),
    Store(
        PAIRED,
        _pair,
        lambda at: [device.name for device in DeviceStore(at).all()],
    ),
    Store(
        FIRST_DRIVE,
        lambda at, n: Record(at).keep("distance", {"measured_mm": 500 * n, "seen_mm": 500}),
        lambda at: Record(at).get("distance"),
    ),
    Store(DIARY, _write_diary, lambda at: len(Diary(at).read())),
    Store(FORWARD, _write_forward, lambda at: ForwardStore(at).step_ms(0, 600, 300)),
    Store(CAMERA_FLOOR, _write_floor, lambda at: FloorStore(at).get()),
    Store(f"{MAPS}/a.map", _write_map, _read_map),
    Store(f"{MAPS}/drives/a", _write_ledger, lambda at: load_ledger(_ledger(at), _GRID).drive_s),
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
        none = store.read(home)
        store.write(home, 1)
        allowed = store.read(home), none, store.damaged
        content = (home / store.file).read_bytes()
        for _ in range(cuts):
            (home / store.file).write_bytes(content[: dice.randrange(len(content))])
            try:
                found.half += store.read(home) not in allowed
                store.write(home, 2)
            except Exception as error:
                found.dead.append(f"{store.file}: {error!r}")
    return found


def cut_certificate(cuts: int, dice: random.Random) -> list[str]:
    """Cuts of each file of tls/, or of their writing: why a host or tablet could not use it."""
    failures = []
    with _folder() as name:
        home, names = Path(name), ["chair.local"]
        folder = Certificate(home, names).authority.parent
        whole = {path: path.read_bytes() for path in sorted(folder.iterdir())}
        makes = Store("tls", lambda at, _: _make_certificate(at, names), lambda _: None)
        for number in range(cuts):
            for path, content in whole.items():
                path.write_bytes(content)
            path = dice.choice(list(whole))
            cut = dice.randrange(len(whole[path]))
            if number % 3:
                (folder / "host.key").unlink()
                _write_until(makes, home, cut, full=number % 3 == 1)
            else:
                path.write_bytes(whole[path][:cut])
            try:
                made = Certificate(home, names)
                made.context()
                ssl.create_default_context(cafile=str(made.authority))
            except Exception as error:
                failures.append(f"tls, {path.name}: {error!r}")
    return failures


def _make_certificate(folder: Path, names: list[str]) -> None:
    Certificate(folder, names)


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
                missed += f"sync {Path(name, store.file).parent}" not in order[at:]
        return missed + (not any(act.startswith("replace ") for act in order))


def _cut_log(cuts: int, dice: random.Random) -> tuple[int, float]:
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
    unreadable, lost_ms = _cut_log(cuts, dice)
    report.add(f"power cut at {cuts} bytes of the log: unreadable", unreadable, "", 0)
    report.add("  lost at most", lost_ms, "ms", _SYNC_MS)
    for store in STORES:
        writing, file = cut_writing(store, cuts, dice), cut_file(store, cuts, dice)
        dead = writing.dead + file.dead
        half = writing.half + file.half
        report.add(f"power cut at {cuts} bytes of {store.file}: half", half, "", 0)
        report.add("  a host would not start or write", len(dead), "", 0)
        report.add("  replaced before it is on the disk", unsynced(store), "", 0)
        for line in dead[:2]:
            report.note(line)
    count = min(cuts, _MOST_CERTIFICATES)
    failures = cut_certificate(count, dice)
    report.add(f"power cut at {count} bytes of tls: not usable", len(failures), "", 0)
    for line in failures[:2]:
        report.note(line)
