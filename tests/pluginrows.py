"""What a host sends the pages about plug-ins: rows of `welcome.plugins`, and `welcome.modes`."""

from __future__ import annotations

from typing import Any

from fakehost import FakeHost

Row = dict[str, Any]
WELL = {"state": "ok", "reason": "ok", "detail": "", "again": None}


def mode(name: str, **changes: Any) -> Row:
    """A working mode with these changes."""
    names = {"nl": name.capitalize(), "en": name.upper()}
    return {"kind": "mode", "name": name, "icon": "↑", "names": names, **WELL, **changes}


def lost(row: Row, reason: str = "plugin_ended", again: int | None = None) -> Row:
    """The same one, lost."""
    detail = f"mode {row['name']} ended unexpectedly; starting it again"
    return {**row, "state": "lost", "reason": reason, "detail": detail, "again": again}


def offer(host: FakeHost, *rows: Row) -> None:
    """Set the host's welcome, and send it at once to connected pages."""
    works = [row for row in rows if row["kind"] == "mode" and row["state"] in ("ok", "degraded")]
    host.welcome["plugins"] = list(rows)
    host.welcome["modes"] = [
        {"mode": row["name"], "auto": row.get("auto", False)}
        | {"icon": row["icon"], "names": row["names"]}
        for row in works
    ]
    host.say(host.welcome)
