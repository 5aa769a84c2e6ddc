"""A program of another Debian suite, unpacked privately with its own loader and libraries."""

from __future__ import annotations

import platform
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from gazesetup import apt
from gazesetup.paths import LOCAL
from gazesetup.progress import NotAvailable, note, say
from gazesetup.venv import locked

Found = TypeVar("Found")

_CHECK_S = 30.0

_WRAPPER = """#!/bin/sh
here=${{0%/*}}
lib=$here/root/usr/lib/{libraries}
exec "$lib/{loader}" --library-path "$lib" "$here/root/usr/{program}" "$@"
"""


@dataclass(frozen=True)
class Private:
    """The machine needs neither packages of that architecture nor such a new C library."""

    name: str  # of its folder in .local and of the program there
    what: str
    program: str  # in /usr, with its folder there
    packages: tuple[str, ...]
    suite: str = "trixie"
    arch: str = "amd64"
    libraries: str = "x86_64-linux-gnu"  # that architecture's folder in /usr/lib, and its loader
    loader: str = "ld-linux-x86-64.so.2"
    machines: tuple[str, ...] = ("x86_64",)  # that can run it
    # (path in the archive's pool, SHA-256): used first if all exist, before the suite's lists.
    pinned: tuple[tuple[str, str], ...] = ()


def ensure(wanted: Private, check: Callable[[Path], Found], local: Path = LOCAL) -> Found:
    """`check` of the program in .local, fetched if it is missing or `check` refuses it.

    `check` runs it and raises NotAvailable; so does this, with the reason.
    """
    folder = local / wanted.name
    wrapper = folder / wanted.name
    with locked(local):
        if wrapper.exists():
            try:
                return check(wrapper)
            except NotAvailable as error:
                note(f"{error}: fetching it again")
        if platform.machine() not in wanted.machines:
            raise NotAvailable(
                f"Debian's {wanted.arch} package does not run on {platform.machine()}"
            )
        archives = apt.debian_archives()
        if not archives:
            raise NotAvailable("this machine's apt sources name no Debian archive")
        with say(f"unpacking {wanted.what} (Debian {wanted.suite}, {wanted.arch}) privately"):
            _fetch(wanted, archives, folder)
            wrapper.write_text(_WRAPPER.format(**vars(wanted)))
            wrapper.chmod(0o755)
            return check(wrapper)


def ask(path: Path, code: str) -> subprocess.CompletedProcess[str]:
    """The result of `-c code` with the interpreter at `path`. NotAvailable: it does not run."""
    try:
        return subprocess.run(
            [path, "-c", code],
            capture_output=True,
            text=True,
            timeout=_CHECK_S,
            stdin=subprocess.DEVNULL,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise NotAvailable(f"{path} does not run ({error})") from error


def last_words(result: subprocess.CompletedProcess[str]) -> str:
    """The last line of an unexpected output."""
    lines = (result.stderr or result.stdout).strip().splitlines()
    return lines[-1] if lines else "it said nothing"


def _fetch(wanted: Private, archives: list[apt.Source], folder: Path) -> None:
    failures = []
    for archive in archives:
        try:
            _empty(folder)
            if wanted.pinned:
                apt.unpack_pinned(archive, wanted.pinned, folder / "root")
                return
        except NotAvailable as error:
            note(f"{error}: asking the suite's lists")
        try:
            _empty(folder)
            apt.unpack(archive, wanted.suite, wanted.arch, wanted.packages, folder / "root")
            return
        except NotAvailable as error:
            failures.append(f"{archive.uri}: {error}")
    raise NotAvailable("; ".join(failures))


def _empty(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
