"""Stores a recorded drive as a regression test: only the trace, without scans, pictures, words."""

from __future__ import annotations

import json
import os
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mcap.writer import Writer

from gazechair.blackbox.reader import LogFile
from gazereplay.board_trace import TRACE, Layout
from gazereplay.replay import kept_layout, of_trace
from gazesetup.paths import ROOT

FOLDER = ROOT / "tests" / "drives"


def keep(path: Path, name: str, folder: Path = FOLDER) -> Path:
    """Copy the trace of the log at `path` to where the tests find it.

    Raises ValueError for the name or the log, OSError; a drive of that name then stays as it was.
    """
    if not re.fullmatch(r"[\w-]+", name):
        raise ValueError(f"{name!r} is no name for a test: letters, digits, - and _")
    folder.mkdir(exist_ok=True)
    target = folder / f"{name}.mcap"
    # The log may be the very drive that this replaces.
    fresh = target.with_suffix(".new")
    try:
        traced = _copy(path, fresh)
        os.replace(fresh, target)
    finally:
        fresh.unlink(missing_ok=True)
    if traced:
        # The names of its words, so that a core with other words can use it, too.
        layout = kept_layout(path) or Layout.ours()
        target.with_suffix(".json").write_text(json.dumps(asdict(layout)))
    return target


def _copy(path: Path, target: Path) -> bool:
    """Copy the messages for the replay; True if a board sent them as its trace."""
    with target.open("wb") as file:
        writer: Any = Writer(file)
        writer.start(profile="ros2", library="gazechair")
        channels: dict[str, int] = {}
        for line in of_trace(LogFile(path)):
            if line.topic not in channels:
                schema = writer.register_schema(line.type_name, "ros2msg", line.schema.data)
                channels[line.topic] = writer.register_channel(line.topic, "cdr", schema)
            writer.add_message(channels[line.topic], line.at_ns, line.data, line.at_ns)
        writer.finish()
    return TRACE in channels
