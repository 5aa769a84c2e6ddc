"""The package: wheels of everything, pinned by their hashes, the service, and its installer.

/usr/share/gazechair  wheels for each Python in PYTHONS, and locked.txt
/opt/gazechair        one virtual environment per version, made from them while installing;
                      `current` is the one in use, `before` the one before it
/etc/gazechair        the configuration
/var/lib/gazechair    paired devices, profiles, certificate, log
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

from gazechair.config import configuration
from gazedeb.udev import rules
from gazelink import VERSION
from gazesetup import LOCAL, ROOT, NotAvailable, say
from gazesetup.venv import locked

PYTHONS = ("3.11", "3.12", "3.13")
"""Debian 12, Ubuntu 24.04, Debian 13."""
_FILES = Path(__file__).resolve().parent / "files"
LOCKED = Path(__file__).resolve().parent / "locked.txt"
EXTRAS = ("alerts", "bench", "flash", "gamepad", "home", "log", "picture", "qr")
"""Every one that the host uses on a chair, except oak; docs/install.md says so."""
_PLATFORMS = ("manylinux_2_28_x86_64", "manylinux2014_x86_64", "manylinux_2_17_x86_64")
_NO_WHEEL = ("rplidar-roboticia",)  # published only as source; pure Python
_CONTROL = """\
Package: gazechair
Version: {version}
Architecture: amd64
Section: misc
Priority: optional
Maintainer: gazechair <gazechair@localhost>
Installed-Size: {size_kb}
Depends: python3 (>= 3.11), python3 (<< 3.14), python3-venv, openssl, passwd, util-linux
Description: drives a power wheelchair with the eyes
 The host between an eye-controlled tablet and the microcontroller that imitates the
 wheelchair's joystick: daemon, pages, and commands to flash, calibrate and tune.
"""


def version_of(checkout: Path) -> str:
    """A version that Debian sorts correctly: the version, number of commits, and last commit.

    With changes that are not committed also the time, UTC: the installer makes an environment for
    each version once.
    """
    count, commit, changed = (
        subprocess.run(
            ["git", "-C", str(checkout), *words], capture_output=True, text=True, check=True
        ).stdout.strip()
        for words in (
            ["rev-list", "--count", "HEAD"],
            ["rev-parse", "--short=12", "HEAD"],
            ["status", "--porcelain", "--untracked-files=normal"],
        )
    )
    mark = time.strftime(".%Y%m%d%H%M%S", time.gmtime()) if changed else ""
    return f"{'.'.join(map(str, VERSION))}+{count}.{commit}{mark}"


def build(version: str, folder: Path) -> Path:
    """The package of this checkout as `version`, in `folder`. Raises NotAvailable."""
    if shutil.which("dpkg-deb") is None:
        raise NotAvailable("dpkg-deb is missing: build on Debian or Ubuntu")
    folder.mkdir(parents=True, exist_ok=True)
    package = folder / f"gazechair_{version}_amd64.deb"
    with tempfile.TemporaryDirectory() as made:
        root = Path(made)
        root.chmod(0o755)
        shared = root / "usr/share/gazechair"
        with say("collecting wheels"):
            shutil.copytree(_wheels(), shared / "wheels")
        with say("building gazechair's own"):
            own_wheel(ROOT, shared / "wheels")
        (shared / "locked.txt").write_text(_hashed(shared / "wheels"))
        _lay_out(root, version)
        size_kb = sum(f.stat().st_size for f in root.rglob("*") if f.is_file()) // 1024
        control = root / "DEBIAN"
        (control / "control").write_text(_CONTROL.format(version=version, size_kb=size_kb))
        with say(f"building {package.name}"):
            # The wheels are compressed already.
            words = ["dpkg-deb", "--root-owner-group", "-Zgzip", "-z1", "--build", made]
            subprocess.run([*words, str(package)], check=True, capture_output=True)
    return package


def own_wheel(checkout: Path, folder: Path) -> None:
    """Write the wheel of `checkout` alone into `folder`. Raises NotAvailable."""
    with tempfile.TemporaryDirectory() as made:
        # The checkout's build/lib still has modules that were removed or renamed.
        settings = Path(made) / "distutils.cfg"
        settings.write_text(f"[build]\nbuild_base = {made}\n")
        env = os.environ | {"DIST_EXTRA_CONFIG": str(settings)}
        _pip("wheel", "--no-deps", "--wheel-dir", str(folder), str(checkout), env=env)


def _lay_out(root: Path, version: str) -> None:
    for place, names, mode in (
        ("DEBIAN", ("postinst", "prerm", "postrm"), 0o755),
        ("usr/bin", ("gazechair",), 0o755),
        ("usr/sbin", ("gazechair-version",), 0o755),
        ("usr/lib/systemd/system", ("gazechair.service",), 0o644),
    ):
        (root / place).mkdir(parents=True, exist_ok=True)
        for name in names:
            text = (_FILES / name).read_text().replace("@VERSION@", version)
            (root / place / name).write_text(text)
            (root / place / name).chmod(mode)
    for place, text in (
        # 61: after 60-serial.rules, which finds the serial number that the names have.
        ("usr/lib/udev/rules.d/61-gazechair.rules", rules()),
        ("etc/gazechair/gazechair.toml", _configuration()),
        ("DEBIAN/conffiles", "/etc/gazechair/gazechair.toml\n"),
    ):
        (root / place).parent.mkdir(parents=True, exist_ok=True)
        (root / place).write_text(text)


def _configuration() -> str:
    """Sets only what differs from the defaults: the page is reachable from the network."""
    text = configuration.annotated_default()
    default = '#host = "127.0.0.1"'
    assert text.count(default) == 1
    return text.replace(default, 'host = "0.0.0.0"')


def _wheels() -> Path:
    """A folder with the wheels of every pinned package for every Python; fetched once."""
    key = hashlib.sha256(f"{LOCKED.read_text()}{PYTHONS}{_PLATFORMS}".encode()).hexdigest()[:16]
    kept = LOCAL / "deb" / key
    with locked(LOCAL):
        if kept.is_dir():
            return kept
        shutil.rmtree(kept.parent, ignore_errors=True)
        kept.parent.mkdir(parents=True)
        with tempfile.TemporaryDirectory(dir=kept.parent) as made:
            fetched = Path(made) / "wheels"
            _fetch(fetched)
            fetched.rename(kept)
    return kept


def _fetch(folder: Path) -> None:
    pinned = [line for line in LOCKED.read_text().splitlines() if line]
    source = [line for line in pinned if line.partition("==")[0] in _NO_WHEEL]
    # PEP 517: the old way needs the package `wheel`, which a virtual environment lacks.
    _pip("wheel", "--use-pep517", "--no-deps", "--wheel-dir", str(folder), *source)
    for python in PYTHONS:
        platforms = [word for platform in _PLATFORMS for word in ("--platform", platform)]
        target = ["--python-version", python, *platforms, "--only-binary=:all:"]
        wanted = [line for line in pinned if line not in source]
        _pip("download", "--no-deps", "--dest", str(folder), *target, *wanted)


def _hashed(wheels: Path) -> str:
    """The requirements for pip: each package with its version and hashes."""
    hashes = defaultdict(list)
    for wheel in sorted(wheels.glob("*.whl")):
        name, version = wheel.name.split("-")[:2]
        extras = f"[{','.join(EXTRAS)}]" if name == "gazechair" else ""
        digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
        hashes[f"{name}{extras}=={version}"].append(f"--hash=sha256:{digest}")
    return "".join(f"{one} {' '.join(files)}\n" for one, files in hashes.items())


def _pip(*words: str, env: Mapping[str, str] | None = None) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *words],
        env=env,
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        raise NotAvailable(f"pip {words[0]} failed: {last}")
