"""Debian's package tools: the machine's own mirrors, installing as root, unpacking privately."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import time
import urllib.request
from collections.abc import Sequence
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path

from gazesetup.progress import NotAvailable, note, run_quietly, say

SOURCES = Path("/etc/apt")
LISTS = Path("/var/lib/apt/lists")
KEYRINGS = (
    Path("/usr/share/keyrings/debian-archive-keyring.gpg"),
    Path("/usr/share/keyrings/debian-archive-keyring.pgp"),
)
LISTS_OLD_S = 24 * 3600
# A mirror that is being synchronised may serve lists and checksums of different days.
RETRY_AFTER_S = (5, 15, 30)
POOL_TIMEOUT_S = 60
ONE_LINE = re.compile(
    r"\s*deb\s+(\[(?P<options>[^]]*)\]\s+)?(?P<uri>\S+)\s+(?P<suite>\S+)(?P<components>.*)"
)


@dataclass(frozen=True)
class Source:
    """One archive the machine installs from; `signed_by` is a key file's path or empty."""

    uri: str
    suites: tuple[str, ...]
    components: tuple[str, ...]
    signed_by: str = ""


def install(package: str, *, what: str) -> None:
    """Install a Debian package, as root only. Raises NotAvailable, naming the command to type."""
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        raise NotAvailable(f"{what} is missing: install it (on Debian: apt install {package})")
    env = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    with say(f"installing {package} with apt-get"):
        if lists_are_old():
            run_quietly(["apt-get", "update"], env=env)
        run_quietly(
            ["apt-get", "install", "-y", "--no-install-recommends", package],
            show=lambda line: line[:90] if line.startswith(("Get:", "Unpacking")) else None,
            env=env,
        )


def lists_are_old(lists: Path = LISTS) -> bool:
    """Whether apt's package lists are missing or older than a day."""
    newest = max((file.stat().st_mtime for file in lists.glob("*_Packages*")), default=0.0)
    return time.time() - newest > LISTS_OLD_S


def debian_archives(
    etc: Path = SOURCES, os_release: Path = Path("/etc/os-release")
) -> list[Source]:
    """The Debian archives this machine itself installs from, in its own order; empty elsewhere."""
    release = parse_os_release(os_release.read_text() if os_release.exists() else "")
    if release.get("ID") != "debian":
        return []
    found = []
    for source in read_sources(etc):
        own = not source.suites or release.get("VERSION_CODENAME") in source.suites
        if own and "main" in source.components and not source.uri.startswith("cdrom:"):
            found.append(source)
    return found


def read_sources(etc: Path = SOURCES) -> list[Source]:
    """Every binary source in /etc/apt, of both formats."""
    found: list[Source] = []
    parts = etc / "sources.list.d"
    for file in [etc / "sources.list", *sorted(parts.glob("*.list"))]:
        if file.exists():
            found += parse_one_line(file.read_text(errors="replace"))
    for file in sorted(parts.glob("*.sources")):
        found += parse_deb822(file.read_text(errors="replace"))
    return found


def parse_one_line(text: str) -> list[Source]:
    """Sources of the one-line format: deb [options] uri suite component..."""
    found = []
    for line in text.splitlines():
        match = ONE_LINE.match(line.partition("#")[0])
        if match:
            options = (match["options"] or "").split()
            keys = (o.partition("=")[2] for o in options if o.startswith("signed-by="))
            components = tuple(match["components"].split())
            found.append(Source(match["uri"], (match["suite"],), components, next(keys, "")))
    return found


def parse_deb822(text: str) -> list[Source]:
    """Sources of the paragraph format (RFC 822 like), one for each URI."""
    found = []
    for fields in _paragraphs(text):
        if fields.get("enabled", "yes").lower() in ("no", "false", "0"):
            continue
        if "deb" not in fields.get("types", "").split():
            continue
        key = fields.get("signed-by", "")
        for uri in fields.get("uris", "").split():
            suites = tuple(fields.get("suites", "").split())
            components = tuple(fields.get("components", "").split())
            found.append(Source(uri, suites, components, key if key.startswith("/") else ""))
    return found


def _paragraphs(text: str) -> list[dict[str, str]]:
    found: list[dict[str, str]] = [{}]
    name = ""
    for line in text.splitlines():
        if line.startswith("#"):
            continue
        if not line.strip():
            found.append({})
        elif line[0] in " \t":
            found[-1][name] = (found[-1].get(name, "") + " " + line.strip()).strip()
        elif ":" in line:
            name, value = line.split(":", 1)
            name = name.strip().lower()
            found[-1][name] = value.strip()
    return [fields for fields in found if fields]


def parse_os_release(text: str) -> dict[str, str]:
    """Fields of /etc/os-release."""
    pairs = (line.split("=", 1) for line in text.splitlines() if "=" in line)
    return {name.strip(): value.strip().strip('"') for name, value in pairs}


def unpack(archive: Source, suite: str, arch: str, packages: Sequence[str], target: Path) -> None:
    """Download packages of another suite and architecture and unpack them into `target`.

    Needs no root and leaves the machine's own package state alone: apt runs on a private
    configuration. Raises NotAvailable.
    """
    for tool in ("apt-get", "dpkg"):
        if shutil.which(tool) is None:
            raise NotAvailable(f"{tool} is missing: this needs Debian's package tools")
    with tempfile.TemporaryDirectory(prefix="gazechair-apt-") as folder:
        work = Path(folder)
        for name in ("lists/partial", "archives/partial"):
            (work / name).mkdir(parents=True)
        (work / "status").touch()
        (work / "sources.list").write_text(_one_line(archive, suite, arch))
        options = {
            "Dir::Etc::sourcelist": work / "sources.list",
            "Dir::Etc::sourceparts": "/dev/null",
            "Dir::State::lists": work / "lists",
            "Dir::State::status": work / "status",
            "Dir::Cache": work,
            "APT::Architecture": arch,
            "APT::Architectures": arch,
            "APT::Sandbox::User": "",
            "Acquire::Languages": "none",
            "Acquire::Retries": "2",
            "Acquire::http::Timeout": "60",
        }
        apt_get: list[str | Path] = ["apt-get"]
        for name, value in options.items():
            apt_get += ["-o", f"{name}={value}"]
        _again_while_failing([*apt_get, "update"], cwd=work)
        _again_while_failing([*apt_get, "download", *packages], cwd=work)
        for file in sorted(work.glob("*.deb")):
            run_quietly(["dpkg", "-x", file, target])


def unpack_pinned(archive: Source, files: Sequence[tuple[str, str]], target: Path) -> None:
    """Download files of the archive's pool, (path, SHA-256) each, and unpack them into `target`.

    Needs no lists: while a mirror is being synchronised its lists fit no checksum for hours.
    Raises NotAvailable, also when a file differs from the pinned one.
    """
    if shutil.which("dpkg") is None:
        raise NotAvailable("dpkg is missing: this needs Debian's package tools")
    with tempfile.TemporaryDirectory(prefix="gazechair-pool-") as folder:
        debs = []
        for path, sha256 in files:
            url = f"{archive.uri.rstrip('/')}/{path}"
            try:
                with urllib.request.urlopen(url, timeout=POOL_TIMEOUT_S) as answer:
                    content = answer.read()
            except (OSError, ValueError, HTTPException) as error:
                raise NotAvailable(f"{url}: {error}") from error
            if hashlib.sha256(content).hexdigest() != sha256:
                raise NotAvailable(f"{url} is not the file that was pinned")
            debs.append(Path(folder, Path(path).name))
            debs[-1].write_bytes(content)
        for file in debs:
            run_quietly(["dpkg", "-x", file, target])


def _again_while_failing(command: Sequence[str | Path], cwd: Path) -> None:
    """Run it, and once more after each pause while it fails. Raises the last try's NotAvailable."""
    for pause_s in (*RETRY_AFTER_S, None):
        try:
            run_quietly(command, cwd=cwd)
            return
        except NotAvailable:
            if pause_s is None:
                raise
            note(f"once more in {pause_s} s")
            time.sleep(pause_s)


def _one_line(archive: Source, suite: str, arch: str) -> str:
    keys = [archive.signed_by, *(str(file) for file in KEYRINGS)]
    key = next((file for file in keys if file and Path(file).exists()), "")
    signed_by = f" signed-by={key}" if key else ""
    return f"deb [arch={arch}{signed_by}] {archive.uri} {suite} main\n"
