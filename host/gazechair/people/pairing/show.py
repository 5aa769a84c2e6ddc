"""Terminal output of pairing: a code with its address and QR code, the list of devices."""

from __future__ import annotations

import io
import time
from collections.abc import Sequence

from gazechair.people.pairing.store import Device


def code_as_text(url: str, code: str, role: str, valid_s: float) -> str:
    """Address, code and, with the package segno (extra "qr"), a QR code to scan."""
    lines = [
        f"Pair a {role}: open {url} and give the code {code}",
        f"or open {url}#{code}",
        f"It works once, within {_duration(valid_s)}.",
    ]
    drawn = qr_text(f"{url}#{code}")
    return "\n".join([*lines, drawn] if drawn else lines)


def qr_rows(text: str) -> list[str] | None:
    """The QR code of a text as rows of "0" and "1", None without the package segno."""
    try:
        import segno
    except ImportError:
        return None
    return ["".join("1" if dark else "0" for dark in row) for row in segno.make(text).matrix]


def devices_as_text(devices: Sequence[Device]) -> str:
    """One line a device."""
    if not devices:
        return "no device is paired; gazechair pair makes a code for one"
    lines = ["id      role       paired            last used         name"]
    for device in devices:
        times = f"{_moment(device.created)}  {_moment(device.last_used)}"
        lines.append(f"{device.id}  {device.role:<9}  {times}  {device.name}")
    return "\n".join(lines)


def qr_text(text: str) -> str | None:
    """The QR code of a text for a terminal, None without the package segno."""
    try:
        import segno
    except ImportError:
        return None
    out = io.StringIO()
    segno.make(text).terminal(out, compact=True, border=2)
    return out.getvalue().rstrip("\n")


def _moment(seconds: int) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))


def _duration(seconds: float) -> str:
    minutes = seconds / 60
    return f"{minutes:.0f} minutes" if minutes < 120 else f"{minutes / 60:.0f} hours"
