"""Finds a MicroPython for the computer, 32-bit like the board's if the machine can run one."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import NamedTuple

from gazesetup import private
from gazesetup.paths import LOCAL
from gazesetup.progress import NotAvailable, note

_DEBIAN = private.Private(
    name="micropython",
    what="32-bit MicroPython",
    program="bin/micropython",
    arch="i386",
    libraries="i386-linux-gnu",
    loader="ld-linux.so.2",
    machines=("x86_64", "i686"),
    packages=(
        "micropython",
        "libc6",
        "libffi8",
        "libmbedcrypto16",
        "libmbedtls21",
        "libmbedx509-7",
    ),
    pinned=(
        (
            "pool/main/g/glibc/libc6_2.41-12+deb13u4_i386.deb",
            "67bb4b54cf4bb6a380449dfa1852cd9135659f85360caa0e41d312f4b30e573a",
        ),
        (
            "pool/main/libf/libffi/libffi8_3.4.8-2_i386.deb",
            "8bafefb38c320ca27796070c881595ce04d900c3b534ac142a494daf1fe1db13",
        ),
        (
            "pool/main/m/mbedtls/libmbedcrypto16_3.6.6-0.1~deb13u1_i386.deb",
            "aa4698ed436eebf77e3dc9f5c514073bd554109d857d887db5a367dde9a5c377",
        ),
        (
            "pool/main/m/mbedtls/libmbedtls21_3.6.6-0.1~deb13u1_i386.deb",
            "eb1b20154ce9008aca1d036698ffc12019020a54985d2c5ae3dc1c1c39c9e995",
        ),
        (
            "pool/main/m/mbedtls/libmbedx509-7_3.6.6-0.1~deb13u1_i386.deb",
            "fe6ba192c9227d30a4cd05a3bdeccdf9ff30d55b27d8ff488126c16dcf727cce",
        ),
        (
            "pool/main/m/micropython/micropython_1.25.0+ds-1_i386.deb",
            "a72799821cb45442150f8a7f0757bc8e4f9a4b64abccbd837d694a20d6900bb5",
        ),
    ),
)
CHECK = (
    "import sys; print(sys.implementation.name, '.'.join(str(n) for n in"
    " sys.implementation.version[:3]), 32 if sys.maxsize < 1 << 32 else 64)"
)


class MicroPython(NamedTuple):
    """A MicroPython that runs, and in words which one it is (version, 32-bit or 64-bit, whence)."""

    path: Path
    description: str


def ensure_micropython(*, local: Path = LOCAL) -> MicroPython:
    """The best MicroPython for this machine, checked by running it.

    In this order: $GAZECHAIR_MICROPYTHON, which must work when given; the one unpacked earlier in
    .local/micropython; Debian's 32-bit package, unpacked there; `micropython` on PATH (with a
    notice when 64-bit). Raises NotAvailable with the reason.
    """
    given = os.environ.get("GAZECHAIR_MICROPYTHON", "")
    if given:
        try:
            return check(Path(given).absolute(), "given by GAZECHAIR_MICROPYTHON")
        except NotAvailable as error:
            raise NotAvailable(f"{error}: correct or unset GAZECHAIR_MICROPYTHON") from error
    try:
        return _unpacked(local)
    except NotAvailable as error:
        reason = str(error)
    native = shutil.which("micropython")
    if native is None:
        raise NotAvailable(
            f"no MicroPython: {reason}; none on PATH either (build one, or apt install micropython)"
        )
    note(f"no private 32-bit MicroPython ({reason}): using {native}")
    found = check(Path(native), "on PATH")
    if "32-bit" not in found.description:
        note("it is 64-bit: allocation and integer limits differ from the board's")
    return found


def check(path: Path, whence: str) -> MicroPython:
    """Run `path` and describe it. Raises NotAvailable when it is no working MicroPython."""
    result = private.ask(path, CHECK)
    words = result.stdout.split()
    if result.returncode != 0 or len(words) != 3 or words[0] != "micropython":
        raise NotAvailable(f"{path} is no MicroPython ({private.last_words(result)})")
    return MicroPython(path, f"MicroPython {words[1]}, {words[2]}-bit, {whence}")


def _unpacked(local: Path) -> MicroPython:
    """Debian's 32-bit package in .local/micropython, fetched when it is not there or broken."""
    return private.ensure(_DEBIAN, lambda path: check(path, "Debian's, in micropython"), local)
