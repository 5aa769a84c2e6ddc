"""The stored maps: one file each in a folder of the state folder, changed atomically.

`ID.map` is the map, `ID.before` the version before its last change. An unusable file is reported,
and the version before it is used instead. Names are in the files: no file is named by what
somebody typed. `older/ID.N` are the versions before later drives changed it, the newest with the
largest N; `drives/ID` holds what those drives found.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import secrets
import threading
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gazechair.base.state_folder import set_aside
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import HomeMap, MapError, NewerMapError, load
from gazechair.sensing.mapping.stored.places import (
    Drawn,
    EditRefused,
    free_name,
    name_of,
    same_name,
)

FOLDER = "maps"  # in the state folder
_SUFFIX, _BEFORE = ".map", ".before"
_HALVES = ".new", ".kept"
_DAMAGED = ".damaged"
_OLDER, _DRIVES = "older", "drives"
_MOST_OLDER = 5
_ID = re.compile(r"[A-Za-z0-9_-]{1,40}")
_TAKEN_IDS = "where", "growing"  # addresses of something else: see web/map_routes.py

_Facts = tuple[int, int, int]


@dataclass(frozen=True)
class Stored:
    """One file: its map, and what is wrong with it."""

    id: str
    map: HomeMap | None
    """None: neither the file nor the version before it can be used."""
    problem: str = ""
    """One plain line; if there is a `map`, it is the version before."""
    newer: bool = False
    """A newer gazechair has written the file: it is not changed."""
    floor_m2: float = 0.0
    """Area of the free floor."""


class MapStore:
    """Thread-safe. Reads a file again when it has changed, also by another process."""

    MOST = 20

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = threading.Lock()
        self._read: dict[str, tuple[_Facts, Stored]] = {}

    def tidy(self) -> None:
        """At the start: clear up after a process that ended while storing."""
        for suffix in _HALVES:
            for path in self.folder.glob("*" + suffix):
                with contextlib.suppress(OSError):
                    path.unlink()

    def all(self) -> list[Stored]:
        """All maps, ordered by id; at most MOST."""
        with self._lock:
            return self._all()

    def get(self, id_: str) -> Stored | None:
        """The map with that id; None: there is none."""
        return next((one for one in self.all() if one.id == id_), None)

    def version(self, id_: str) -> int:
        """Another number after each change of the map's file; 0: it is gone. Never waits."""
        try:
            return zlib.crc32(repr(_facts(self.folder / (id_ + _SUFFIX))).encode())
        except OSError:
            return 0

    def path_of_new(self) -> Path:
        """Path for saving a newly made map."""
        return self.folder / f"{secrets.token_hex(4)}{_SUFFIX}"

    def check_name(self, text: Any) -> str:
        """`text` as a valid name for another map. Raises EditRefused."""
        stored = self.all()
        name = _unused(text, stored)
        if len(stored) >= self.MOST:
            raise _full()
        return name

    def add(self, home: HomeMap, file: str = "") -> str:
        """Add a map, under its name or a similar free one; returns its id. Raises EditRefused.

        `file`: the name of its file; "": any.
        """
        path = self.folder / file if file else self.path_of_new()
        if path.suffix != _SUFFIX or not _ID.fullmatch(path.stem):
            line = f"{path}: name it A{_SUFFIX}; A has 1 to 40 letters a-z, digits, _ and -"
            raise EditRefused("map_name", line)
        if path.stem in _TAKEN_IDS:
            raise EditRefused("map_name", f"{path}: it can't be shown under this name; use another")
        with self._locked(make=True):
            stored = self._all()
            if len(stored) >= self.MOST:
                raise _full()
            others = [one.map for one in stored if one.map is not None]
            same = next((one for one in others if one.grid.is_copy_of(home.grid)), None)
            if same is not None:
                raise EditRefused("map_known", f"this map is stored already: {same.name}")
            name = free_name(home.name, [one.name for one in others])
            replace(home, name=name).save(path)
        return path.stem

    def rename(self, id_: str, text: Any) -> None:
        """Change the map's name. Raises EditRefused."""

        def renamed(home: HomeMap) -> HomeMap:
            others = [one for one in self._all() if one.id != id_]
            return replace(home, name=_unused(text, others))

        self._change(id_, renamed)

    def draw(self, id_: str, act: str, value: Any) -> None:
        """Do one of ACTS on what people drew on the map. Raises EditRefused."""

        def drawn(home: HomeMap) -> HomeMap:
            found = ACTS[act](home.drawn, value)
            if not home.holds(found):
                raise EditRefused("map_outside", "that is not on the map")
            return replace(home, drawn=found)

        self._change(id_, drawn)

    def delete(self, id_: str) -> None:
        """Delete a map with its earlier and its damaged versions. Raises EditRefused."""
        with self._locked():
            if all(one.id != id_ for one in self._all()):
                raise _gone(id_)
            paths = [self.ledger_path(id_), *self._of_older(id_)]
            damaged = self.folder.glob(f"{id_}{_DAMAGED}*")
            paths += [one for one in damaged if one.is_file()]
            paths += [self.folder / (id_ + suffix) for suffix in (_BEFORE, _SUFFIX)]
            for path in paths:
                path.unlink(missing_ok=True)

    def update(self, id_: str, was: OccupancyGrid, grid: OccupancyGrid, when: str) -> bool:
        """Replace the map's grid by one from later drives; False: it is no longer `was`.

        `when`: ISO 8601, UTC. The version before is kept in `older`. Raises EditRefused.
        """

        def updated(home: HomeMap) -> HomeMap | None:
            return replace(home, grid=grid, updated=when) if home.grid.same_as(was) else None

        if not self._change(id_, updated, self._keep_older):
            return False
        for one in self._older(id_)[:-_MOST_OLDER]:
            with contextlib.suppress(OSError):
                one.unlink()
        return True

    def take_back(self, id_: str) -> bool:
        """Undo the newest update by drives, not what people drew; False: there is none.

        Raises EditRefused.
        """
        used: list[Path] = []

        def earlier(home: HomeMap) -> HomeMap | None:
            for path in reversed(self._older(id_)):
                older = self._version(path)
                used.append(path)
                own = older.made == home.made and older.grid.lies_as(home.grid)
                if own and not older.grid.same_as(home.grid):
                    return replace(home, grid=older.grid, updated=older.updated)
            return None

        done = self._change(id_, earlier)
        for path in used:
            with contextlib.suppress(OSError):  # it is passed over the next time
                path.unlink()
        return done

    def note(self, id_: str, save: Callable[[Path], None]) -> None:
        """Call `save` with the path of the map's ledger, unless the map is gone.

        Raises EditRefused.
        """
        with self._locked():
            if (self.folder / (id_ + _SUFFIX)).exists():
                save(self.ledger_path(id_))

    def updates(self, id_: str) -> int:
        """How many updates by drives can be taken back."""
        return len(self._older(id_))

    def ledger_path(self, id_: str) -> Path:
        """Path of the record of what later drives found; see Ledger."""
        return self.folder / _DRIVES / id_

    def _of_older(self, id_: str) -> list[Path]:
        return [one for one in (self.folder / _OLDER).glob(id_ + ".*") if one.stem == id_]

    def _older(self, id_: str) -> list[Path]:
        """The newest last; without leftovers of an update that was not stored."""
        now = _inode(self.folder / (id_ + _SUFFIX))
        return [one for one in self._numbered(id_) if _inode(one) != now]

    def _numbered(self, id_: str) -> list[Path]:
        numbered = [one for one in self._of_older(id_) if one.suffix[1:].isdecimal()]
        return sorted(numbered, key=lambda one: int(one.suffix[1:]))

    def _version(self, path: Path) -> HomeMap:
        """Load one of `older`. A damaged one is set aside; raises EditRefused."""
        try:
            return load(path)
        except NewerMapError as error:
            raise EditRefused("map_damaged", str(error)) from None
        except MapError as error:
            with contextlib.suppress(OSError):
                set_aside(path)
            line = f"{error}; nothing is changed, and the next time it is the version before that"
            raise EditRefused("map_older_damaged", line) from None

    def _keep_older(self, path: Path) -> None:
        numbers = [int(one.suffix[1:]) for one in self._older(path.stem)]
        (self.folder / _OLDER).mkdir(mode=0o700, exist_ok=True)
        _link(path, self.folder / _OLDER / f"{path.stem}.{max(numbers, default=0) + 1}")

    @contextlib.contextmanager
    def _locked(self, make: bool = False) -> Iterator[None]:
        """Exclusive access across threads and processes, as mapping's process changes maps, too.

        Readers do not wait for other processes. `make`: the folder, if there is none. What the disk
        refuses within, or no longer has, is an EditRefused.
        """
        try:
            if make:
                self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            handle = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX)
                with self._lock:
                    yield
            finally:
                os.close(handle)
        except OSError as error:
            line = f"{error.filename or self.folder}: {error.strerror}"
            gone = isinstance(error, FileNotFoundError)
            raise EditRefused("map_gone" if gone else "map_not_stored", line) from None
        except MapError as error:
            raise EditRefused("map_not_stored", str(error)) from None

    def _all(self) -> list[Stored]:
        found: dict[str, tuple[_Facts, Stored]] = {}
        for path in sorted(self.folder.glob("*" + _SUFFIX)):
            if _ID.fullmatch(path.stem) and len(found) < self.MOST:
                with contextlib.suppress(OSError):  # it has just been removed
                    found[path.stem] = self._one(path)
        self._read = found
        return [one for _, one in found.values()]

    def _change(
        self,
        id_: str,
        act: Callable[[HomeMap], HomeMap | None],
        keep: Callable[[Path], None] = lambda _: None,
    ) -> bool:
        """Store what `act` makes of the map, after `keep`; False: `act` returned None."""
        with self._locked():
            stored = next((one for one in self._all() if one.id == id_), None)
            if stored is None:
                raise _gone(id_)
            path = self.folder / (id_ + _SUFFIX)
            if stored.map is None or stored.newer:
                raise EditRefused("map_damaged", stored.problem)
            changed = act(stored.map)
            if changed is None:
                return False
            done = self._older(id_)
            for one in self._numbered(id_):
                if one not in done:
                    one.unlink()
            keep(path.with_suffix(_BEFORE) if stored.problem else path)
            if stored.problem:
                _link(path, path.with_suffix(_DAMAGED))
            else:
                _keep(path)
            changed.save(path)
        return True

    def _one(self, path: Path) -> tuple[_Facts, Stored]:
        key = _facts(path)
        known = self._read.get(path.stem)
        if known is not None and known[0] == key:
            return known
        try:
            return key, _stored(path.stem, load(path))
        except MapError as error:
            problem, newer = str(error), isinstance(error, NewerMapError)
        try:
            return key, _stored(path.stem, load(path.with_suffix(_BEFORE)), problem, newer)
        except MapError:
            return key, Stored(path.stem, None, problem, newer)


def _stored(id_: str, home: HomeMap, problem: str = "", newer: bool = False) -> Stored:
    floor_m2 = float(home.grid.free.sum()) * home.grid.cell_m**2
    return Stored(id_, home, problem, newer, round(floor_m2, 1))


# What can be drawn: {act: it}
ACTS = {
    "place": Drawn.with_place,
    "remove_place": Drawn.without_place,
    "no_go": Drawn.with_area,
    "remove_no_go": Drawn.without_area,
    "home": Drawn.with_home,
}


def _facts(path: Path) -> _Facts:
    """Facts that differ after the file is replaced. Raises OSError."""
    found = path.stat()
    return found.st_mtime_ns, found.st_size, found.st_ino


def _inode(path: Path) -> int | None:
    try:
        return path.stat().st_ino
    except OSError:
        return None


def _keep(path: Path) -> None:
    """Keep the file as the version before; there is one at all times."""
    fresh = path.with_suffix(_HALVES[1])
    _link(path, fresh)
    os.replace(fresh, path.with_suffix(_BEFORE))


def _link(path: Path, other: Path) -> None:
    if path.is_file():  # a folder in its place is set aside when the file is written
        other.unlink(missing_ok=True)
        os.link(path, other)


def _unused(text: Any, others: list[Stored]) -> str:
    """`text` as a valid name that none of `others` has. Raises EditRefused."""
    name = name_of(text)
    if any(one.map is not None and same_name(one.map.name, name) for one in others):
        raise EditRefused("map_name_taken", f"there is a map {name} already")
    return name


def _full() -> EditRefused:
    return EditRefused("map_full", f"there are at most {MapStore.MOST} maps")


def _gone(id_: str) -> EditRefused:
    return EditRefused("map_gone", f"there is no map {id_!r} any more")
