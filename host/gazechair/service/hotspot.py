"""`gazechair hotspot`: the chair's own WiFi network, for homes without one and for outside.

NetworkManager does the work. Its connection is a file in its own format (nm-settings-keyfile(5)),
written here so that the password is not on a command line.
"""

from __future__ import annotations

import argparse
import configparser
import contextlib
import io
import secrets
import shutil
import subprocess
from pathlib import Path

from gazechair.base.state_folder import replace_file
from gazechair.base.user_error import UserError
from gazechair.people.pairing.show import qr_text

NAME = "gazechair"
ADDRESS = "10.42.0.1"
"""Address of the host, with the pages, in its own network."""
FOLDER = Path("/etc/NetworkManager/system-connections")

_LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"  # no two look alike
_LENGTH = 12  # letters: 59 bits
_LIMIT_S = 45.0


class HotspotError(UserError):
    """Raised when NetworkManager cannot or may not do it."""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser("hotspot", help="the chair's own WiFi, with NetworkManager")
    actions = parser.add_subparsers(title="actions", required=True, metavar="ACTION")
    begin = actions.add_parser("on", help="start it, now and at each boot; shows how to join")
    begin.add_argument("--interface", default="", help="the WiFi adapter (default: any)")
    begin.add_argument("--name", default=NAME, help="the name that tablets and phones see")
    begin.set_defaults(act=lambda options: _print(on(options.name, options.interface)))
    end = actions.add_parser("off", help="end it; the adapter may join other networks again")
    end.set_defaults(act=lambda _: _print(off()))
    show = actions.add_parser("show", help="how to join: name, password, QR code")
    show.set_defaults(act=lambda _: _print(join()))


def on(ssid: str = NAME, interface: str = "", folder: Path = FOLDER) -> str:
    """Create and start it; keeps an existing password. Returns how to join.

    HotspotError, also for Ctrl-C: it is as it was before, started again if there was one.
    """
    if not 1 <= len(ssid.encode()) <= 32:
        raise HotspotError("a network's name has 1 to 32 bytes")
    if not folder.is_dir():
        raise HotspotError(f"there is no {folder}: apt install network-manager")
    password = _read(folder).get("wifi-security", "psk", fallback="") or _made()
    file = _file(folder)
    try:
        before = file.read_bytes() if file.exists() else None
        try:
            replace_file(file, keyfile(ssid, password, interface).encode())
            _start(file)
        except (HotspotError, KeyboardInterrupt) as error:
            with contextlib.suppress(HotspotError, OSError):
                _put_back(file, before)
            if isinstance(error, KeyboardInterrupt):
                raise HotspotError("ended by Ctrl-C; it is as it was before") from None
            raise
    except OSError as error:
        raise HotspotError(f"{file}: {error.strerror}; run it with sudo") from None
    return join(folder)


def _start(file: Path) -> None:
    _nmcli("connection", "load", str(file))
    _nmcli("--wait", str(int(_LIMIT_S) - 5), "connection", "up", "id", NAME)


def _put_back(file: Path, before: bytes | None) -> None:
    if before is not None:
        replace_file(file, before)
        _start(file)
        return
    with contextlib.suppress(HotspotError):
        _nmcli("connection", "delete", "id", NAME)
    file.unlink(missing_ok=True)  # one that was never loaded


def off(folder: Path = FOLDER) -> str:
    """Stop it and delete its password. Raises HotspotError."""
    if not _file(folder).exists():
        raise HotspotError("there is no hotspot; gazechair hotspot on makes one")
    _nmcli("connection", "delete", "id", NAME)
    return "the hotspot is off; its password is forgotten"


def join(folder: Path = FOLDER) -> str:
    """How a tablet or phone joins it. Raises HotspotError."""
    made = _read(folder)
    if not (made.has_option("wifi-security", "psk") and made.has_option("wifi", "ssid")):
        raise HotspotError(
            "there is no hotspot that can be read: use sudo, or gazechair hotspot on"
        )
    ssid, password = made["wifi"]["ssid"], made["wifi-security"]["psk"]
    lines = [
        f"WiFi network {ssid}, password {password}; the chair is at {ADDRESS} in it.",
        f'Its certificate must name that address: name = "{ADDRESS}" under [web].',
        "While it is on, this adapter joins no other network.",
    ]
    drawn = qr_text(joining(ssid, password))
    return "\n".join([*lines, drawn] if drawn else lines)


def keyfile(ssid: str, password: str, interface: str) -> str:
    """The connection for NetworkManager."""
    made = configparser.ConfigParser(interpolation=None)
    made["connection"] = {"id": NAME, "type": "wifi", "autoconnect": "true"}
    if interface:
        made["connection"]["interface-name"] = interface
    made["wifi"] = {"mode": "ap", "band": "bg", "ssid": ssid}
    made["wifi-security"] = {"key-mgmt": "wpa-psk", "psk": password}
    made["ipv4"] = {"method": "shared", "address1": f"{ADDRESS}/24"}
    made["ipv6"] = {"method": "disabled"}
    out = io.StringIO()
    made.write(out, space_around_delimiters=False)
    return out.getvalue()


def joining(ssid: str, password: str) -> str:
    """The text of a QR code with which phones join, in ZXing's format."""
    ssid, password = (
        "".join("\\" + c if c in '\\;,:"' else c for c in part) for part in (ssid, password)
    )
    return f"WIFI:T:WPA;S:{ssid};P:{password};;"


def _made() -> str:
    return "".join(secrets.choice(_LETTERS) for _ in range(_LENGTH))


def _file(folder: Path) -> Path:
    return folder / f"{NAME}.nmconnection"


def _read(folder: Path) -> configparser.ConfigParser:
    found = configparser.ConfigParser(interpolation=None)
    with contextlib.suppress(OSError, configparser.Error, UnicodeDecodeError):
        found.read_string(_file(folder).read_text("utf-8"))
    return found


def _nmcli(*arguments: str) -> None:
    program = shutil.which("nmcli")
    if program is None:
        raise HotspotError("NetworkManager is not installed: apt install network-manager")
    try:
        done = subprocess.run(
            [program, *arguments], capture_output=True, text=True, timeout=_LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise HotspotError(f"nmcli {arguments[0]} did not answer within {_LIMIT_S:.0f} s") from None
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise HotspotError(
            lines[0] if lines else f"nmcli {arguments[0]} failed ({done.returncode})"
        )


def _print(line: str) -> int:
    print(line)
    return 0
