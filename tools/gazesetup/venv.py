"""The checkout's own virtual environment, .local/venv: rebuilt when its inputs change."""

from __future__ import annotations

import fcntl
import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gazesetup import apt, interpreter
from gazesetup.paths import LOCAL, ROOT, source_environment
from gazesetup.progress import NotAvailable, note, run_quietly, say

PIP_NOTES = ("Collecting", "Downloading", "Building", "Installing")


def ensure_venv(extras: Iterable[str] = (), *, root: Path = ROOT, local: Path = LOCAL) -> Path:
    """Path of the venv's Python, with gazechair installed editable and at least these `extras`.

    It is rebuilt when its Python, the checkout's path, pyproject.toml or setup.py changed,
    or when a previous attempt was interrupted. Raises NotAvailable with the reason; a venv that
    could not be rebuilt stays, for when the change is taken back.
    """
    venv = local / "venv"
    python = venv / "bin" / "python"
    stamp = venv / "gazechair-stamp.json"
    base = interpreter.best()
    basis = _basis(root, base)
    with locked(local):
        wanted = set(extras)
        installed = _installed(stamp, basis) if python.exists() else None
        if installed is not None and wanted <= installed:
            return python
        if installed is None:
            with _replacing(venv, stamp):
                _make(venv, python, base)
                _install(python, root, sorted(wanted))
                _mark(stamp, basis, wanted)
            return python
        had = stamp.read_text()
        stamp.unlink()
        wanted |= installed
        try:
            _install(python, root, sorted(wanted))
        except NotAvailable:
            # pip downloads everything before it changes anything: the venv is as it was.
            stamp.write_text(had)
            raise
        _mark(stamp, basis, wanted)
        return python


def enter_venv(extras: Iterable[str] = ()) -> None:
    """Continue inside the venv: return when already there, else start this same command there."""
    python = ensure_venv(extras)
    if Path(sys.prefix).resolve() != python.parent.parent.resolve():
        sys.stdout.flush()
        os.execv(python, [str(python), *sys.argv])


def run_module(command: str, module: str, arguments: Sequence[str]) -> int:
    """Run `python -m module` with what the tests need installed; its exit code.

    2, with the reason printed in the name of `command`, when the set-up fails; 130 after Ctrl-C.
    """
    try:
        python = ensure_venv(["test"])
        words: list[str | Path] = [python, "-m", module, *arguments]
        return subprocess.run(words, env=source_environment()).returncode
    except NotAvailable as error:
        print(f"{command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


@contextmanager
def locked(local: Path) -> Iterator[None]:
    """Lock the set-up of this checkout, waiting for another set-up in progress.

    Raises NotAvailable when `local` cannot be written, then or within.
    """
    try:
        local.mkdir(parents=True, exist_ok=True)
        with open(local / "setup.lock", "w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                note("waiting for another set-up of this checkout to end")
                fcntl.flock(file, fcntl.LOCK_EX)
            yield
    except OSError as error:
        raise NotAvailable(
            f"cannot write {error.filename or local} ({error.strerror}): make {local} yours"
            f' (sudo chown -R "$USER" {local}), or copy the checkout to a disk that can be written'
        ) from error


def _basis(root: Path, base: interpreter.Interpreter) -> str:
    """Digest of everything that the venv depends on."""
    digest = hashlib.sha256()
    for text in (base.version, base.prefix, str(root)):
        digest.update(text.encode() + b"\0")
    for file in ("pyproject.toml", "setup.py"):
        digest.update((root / file).read_bytes() + b"\0")
    return digest.hexdigest()


def _installed(stamp: Path, basis: str) -> set[str] | None:
    """Extras of a complete venv with this basis; None when there is no such venv."""
    try:
        have = json.loads(stamp.read_text())
        return set(have["extras"]) if have["basis"] == basis else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _mark(stamp: Path, basis: str, extras: set[str]) -> None:
    stamp.write_text(json.dumps({"basis": basis, "extras": sorted(extras)}))


@contextmanager
def _replacing(venv: Path, stamp: Path) -> Iterator[None]:
    """A free place for a new venv; when that fails, the last complete one comes back."""
    before = venv.with_name(f"{venv.name}.before")
    if stamp.exists():  # else what an interrupted set-up left, perhaps beside a complete one
        shutil.rmtree(before, ignore_errors=True)
        venv.rename(before)
    shutil.rmtree(venv, ignore_errors=True)
    try:
        yield
    except BaseException:
        shutil.rmtree(venv, ignore_errors=True)
        if before.exists():
            before.rename(venv)
        raise
    shutil.rmtree(before, ignore_errors=True)


def _make(venv: Path, python: Path, base: interpreter.Interpreter) -> None:
    version = base.version.split()[0]
    if importlib.util.find_spec("ensurepip") is None:
        short = ".".join(version.split(".")[:2])
        apt.install(f"python{short}-venv", what="Python's venv module")
    with say(f"making a virtual environment of {base.path}, Python {version}"):
        run_quietly([base.path, "-m", "venv", venv])
        if not python.exists():
            raise NotAvailable(
                f"{base.path} -m venv made no {python}: reinstall Python's venv module"
            )


def _install(python: Path, root: Path, extras: list[str]) -> None:
    target = f"{root}[{','.join(extras)}]" if extras else str(root)
    with say("installing gazechair and what it needs" + "".join(f" +{name}" for name in extras)):
        pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--no-input"]
        run_quietly(
            [*pip, "--progress-bar", "off", "--editable", target],
            show=lambda line: line[:90] if line.startswith(PIP_NOTES) else None,
            cwd=root,
        )
