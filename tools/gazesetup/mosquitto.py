"""Finds Mosquitto, the MQTT broker that the tests of alerts talk to."""

from __future__ import annotations

import subprocess
from pathlib import Path

from gazesetup import private
from gazesetup.paths import LOCAL
from gazesetup.progress import NotAvailable

_MOSQUITTO = private.Private(
    name="mosquitto",
    what="Mosquitto",
    program="sbin/mosquitto",
    packages=(
        "mosquitto",
        "libc6",
        "libcap2",
        "libcjson1",
        "libdlt2",
        "libev4t64",
        "libgcrypt20",
        "libgpg-error0",
        "liblz4-1",
        "liblzma5",
        "libmicrohttpd12t64",
        "libssl3t64",
        "libsystemd0",
        "libuv1t64",
        "libwebsockets19t64",
        "libwrap0",
        "libzstd1",
        "zlib1g",
    ),
)


def ensure_mosquitto(*, local: Path = LOCAL) -> Path:
    """The broker as Debian builds it, unpacked in .local/mosquitto. Raises NotAvailable."""
    return private.ensure(_MOSQUITTO, _checked, local)


def _checked(path: Path) -> Path:
    try:
        result = subprocess.run([path, "-h"], capture_output=True, text=True, timeout=30)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise NotAvailable(f"{path} does not run ({error})") from error
    if "mosquitto version" not in result.stdout:
        raise NotAvailable(f"{path} is no Mosquitto ({private.last_words(result)})")
    return path
