"""The folder for data that survives a restart, and atomic replacement of its files."""

from __future__ import annotations

import contextlib
import logging
import os
from pathlib import Path

_MOST_ASIDE = 10

log = logging.getLogger(__name__)


def state_folder(configured: str) -> Path:
    """The configured folder; else systemd's STATE_DIRECTORY, else $XDG_STATE_HOME/gazechair."""
    if configured:
        return Path(configured).expanduser()
    if os.environ.get("STATE_DIRECTORY"):
        return Path(os.environ["STATE_DIRECTORY"].split(":")[0])
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(base) / "gazechair"


def replace_file(path: Path, content: bytes, durable: bool = True, damaged: bool = False) -> None:
    """Replace the file atomically: after a power cut it has the old content or the new.

    `durable`: the new one, once this returns; `damaged`: the old one is kept under another name, as
    a folder in its place is. Raises OSError, with everything as it was.
    """
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    fresh = path.with_name(path.name + ".new")
    unusable = damaged or (path.is_dir() and not path.is_symlink())
    aside = _aside(path) if unusable and os.path.lexists(path) else None
    write_whole(fresh, path, content, 0o600, aside)
    if durable:
        folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def write_whole(
    fresh: Path, path: Path, content: bytes, mode: int = 0o666, aside: Path | None = None
) -> None:
    """Write `fresh` and move it to `path`, or leave all as it was. OSError.

    The content is on the disk before the name is. `mode`: less the umask; `aside`: where what was
    at `path` goes, at the last moment.
    """
    with contextlib.suppress(FileNotFoundError):
        fresh.unlink()
    # Never through a link that somebody laid there.
    handle = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    moved = False
    try:
        with open(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(handle)
        if aside is not None:
            set_aside(path, aside)
            moved = True
        os.replace(fresh, path)
    except BaseException:  # also Ctrl-C
        with contextlib.suppress(OSError):
            fresh.unlink()  # a partial file would take space on a full disk
        if moved:
            with contextlib.suppress(OSError):
                os.replace(str(aside), path)
        raise


def set_aside(path: Path, place: Path | None = None) -> None:
    """Rename an unusable file or folder to `place`, None: any, so that the host continues without
    it. Raises OSError."""
    place = place or _aside(path)
    os.replace(path, place)
    log.error("%s cannot be used; it is now %s", path, place.name)


def _aside(path: Path) -> Path:
    kept = (path.with_suffix(f".damaged{number or ''}") for number in range(_MOST_ASIDE))
    unused = (place for place in kept if not os.path.lexists(place))
    return next(unused, path.with_suffix(".damaged"))
