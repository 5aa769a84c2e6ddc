"""Gets a plug-in's description from a separate process; the daemon is not involved."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gazechair.base import json_text
from gazechair.base.child_records import DATA, FACTS, RecordReader
from gazechair.config.plugin_tables import PluginConfig
from gazechair.plugins.child import SETTING
from gazechair.plugins.exchange import unpack_facts
from gazechair.plugins.found import Found, find

_PATIENCE_S = 20.0
_LONGEST = 1 << 16


@dataclass(frozen=True)
class Description:
    """One plug-in, or what is wrong with it."""

    about: str = ""
    table: tuple[str, ...] = ()
    """Its configuration table with all defaults, as lines."""
    wrong: str = ""
    """One plain line; "" when nothing is wrong."""
    setting: bool = False
    """True if `wrong` begins with the refused setting."""


def describe(found: Found, settings: Mapping[str, Any] | None = None) -> Description:
    """Import the plug-in, and build it if there are `settings`, in a short-lived child process."""
    how = "describe" if settings is None else "paced"
    argument = {**vars(found), "settings": dict(settings or {}), "how": how}
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
    try:
        done = subprocess.run(
            [sys.executable, "-m", "gazechair.plugins.child", json.dumps(argument)],
            input=b"",
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            timeout=_PATIENCE_S,
        )
    except subprocess.TimeoutExpired:
        return Description(wrong=f"did not answer within {_PATIENCE_S:g} s")
    about, wrong, refused = "", "", False
    table: tuple[str, ...] = ()
    try:
        for kind, payload in RecordReader(_LONGEST).feed(done.stdout):
            if kind == FACTS:
                about = unpack_facts(payload).about
            elif kind == DATA:
                table = tuple(str(line) for line in json_text.parse(payload)["table"])
            else:
                status = json_text.parse(payload)
                wrong = str(status["detail"]) if status["state"] == "lost" else ""
                refused = status["reason"] == SETTING
    except (ValueError, KeyError, TypeError) as error:
        wrong = f"sent nonsense: {error}"
    if done.returncode != 0 and not wrong:
        wrong = "its process ended without a message"
    return Description(about, table, wrong, refused)


def examine(config: PluginConfig) -> Description:
    """Describe an enabled plug-in with its settings."""
    try:
        found = find(config.kind, config.name)
    except LookupError as error:
        return Description(wrong=f"{config.lines.get('', '')}: {error}")
    one = describe(found, config.settings)
    if not one.setting:
        return one
    return Description(one.about, one.table, config.refusal(*one.wrong.split(" ", 1)))
