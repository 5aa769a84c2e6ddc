"""Exports messages of the log as JSON lines, CSV, or text for a terminal."""

from __future__ import annotations

import array
import csv
import json
import math
import time
from collections.abc import Iterable, Iterator
from typing import Any, TextIO

from gazechair.blackbox.reader import Line
from gazechair.board.state_log import fault_names
from gazelink import codes

_FACES = {"/rosout", "/board/state", "/host/command", "/host/order", "/board/fault"}


def plain(value: Any) -> Any:
    """A decoded message as JSON-compatible values; bytes as a list, infinity and NaN as null."""
    if isinstance(value, bytes | bytearray | memoryview | array.array):
        return [plain(item) for item in value.tolist()] if hasattr(value, "tolist") else list(value)
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return value


def as_json_lines(lines: Iterable[Line], out: TextIO) -> None:
    """Write one object per line: t (wall time, s), topic, type and the fields."""
    for line in lines:
        head = {"t": line.at_ns / 1e9, "topic": line.topic, "type": line.type_name}
        print(json.dumps({**head, **plain(line.message)}), file=out)


def as_csv(lines: Iterable[Line], out: TextIO) -> None:
    """Write one row per message, all of one topic: t (wall time, s) and the fields."""
    writer = csv.writer(out)
    for at, line in enumerate(lines):
        row = dict(_flat(plain(line.message)))
        if at == 0:
            writer.writerow(["t", *row])
        writer.writerow([f"{line.at_ns / 1e9:.3f}", *row.values()])


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else key)
    elif isinstance(value, list):
        yield name, json.dumps(value)
    else:
        yield name, value


def story(lines: Iterable[Line]) -> Iterator[str]:
    """The log for people: one line for each change of state, command or reason."""
    last: dict[str, str] = {}
    for line in lines:
        if line.topic not in _FACES:
            continue
        text = _text_of(line.topic, line.message)
        if text != last.get(line.topic) or line.topic == "/rosout":
            last[line.topic] = text
            moment = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(line.at_ns // 10**9))
            yield f"{moment}.{line.at_ns // 10**6 % 1000:03} {text}"


def _text_of(topic: str, m: Any) -> str:
    if topic == "/rosout":
        return f"host: {m.msg}"
    if topic == "/board/state":
        faults = ", ".join(fault_names(m.faults)) or "none"
        return (
            f"board: {_name(codes.STATES, m.status & 15)}, {_name(codes.MOTIONS, m.status >> 4)},"
            f" override {codes.reason_name(m.override)}, faults {faults}"
        )
    if topic == "/host/command":
        mode = f" {_name(codes.MODES, m.mode)}" if m.verb != codes.STOP else ""
        return f"command: {_name(codes.VERBS, m.verb)}{mode}, press {m.edge}"
    if topic == "/host/order":
        return f"order: {_name(codes.ORDERS, m.action)} by {_name(codes.OWNERS, m.owner)}"
    return f"board's last words: {codes.reason_name(m.reason)} {m.detail}"


def _name(names: tuple[str, ...], code: int) -> str:
    return names[code] if code < len(names) else str(code)
