"""Programs from the distribution, for tests and benchmarks: Chromium, QEMU, icp-slam."""

from __future__ import annotations

import shutil
from pathlib import Path

from gazesetup import apt
from gazesetup.progress import NotAvailable

CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
HEADLESS_NAMES = ("chromium-headless-shell",)
QEMU_NAMES = ("qemu-system-arm",)
ICP_SLAM_NAMES = ("icp-slam",)


def ensure_chromium() -> Path:
    """A Chromium on PATH, installed when root. Raises NotAvailable with what to install."""
    return _ensure(CHROMIUM_NAMES, "chromium", "Chromium")


def ensure_headless_shell() -> Path:
    """Chromium without its windows, installed when root: a page in it takes half the time.

    Raises NotAvailable where the distribution has none.
    """
    return _ensure(HEADLESS_NAMES, "chromium-headless-shell", "Chromium's headless shell")


def headless_chromium() -> Path:
    """The headless shell where it is installed, else a Chromium as `ensure_chromium` has it."""
    return _on_path(HEADLESS_NAMES) or ensure_chromium()


def ensure_qemu() -> Path:
    """qemu-system-arm on PATH, installed when root. Raises NotAvailable with what to install."""
    return _ensure(QEMU_NAMES, "qemu-system-arm", "QEMU for ARM")


def ensure_icp_slam() -> Path:
    """icp-slam of MRPT on PATH, installed when root. Raises NotAvailable with what to install."""
    return _ensure(ICP_SLAM_NAMES, "mrpt-apps", "icp-slam")


def _ensure(names: tuple[str, ...], package: str, what: str) -> Path:
    found = _on_path(names)
    if found is None:
        apt.install(package, what=what)
        found = _on_path(names)
    if found is None:
        raise NotAvailable(f"{package} was installed, yet none of {', '.join(names)} is on PATH")
    return found


def _on_path(names: tuple[str, ...]) -> Path | None:
    for name in names:
        path = shutil.which(name)
        if path:
            return Path(path)
    return None
