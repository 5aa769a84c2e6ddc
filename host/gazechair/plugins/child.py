"""A plug-in's process: the only place that imports it; calls it, and sends its answers."""

from __future__ import annotations

import json
import os
import select
import sys
import time
from typing import Any

from gazechair.base.child_main import enter_child
from gazechair.base.child_records import RecordWriter
from gazechair.config.tables import BadSetting, described
from gazechair.plugins.caller import InputCaller, ModeCaller, build, facts, load
from gazechair.plugins.contract import Input, Unusable

LOST = "plugin_lost"
RAISED = "plugin_raised"
SETTING = "plugin_setting"
STARTING = "plugin_starting"
_LEAST_S = 0.004  # between two values: an input that is always readable must not flood
_IDLE_S = 0.25
_RATES_HZ = (4.0, 100.0)
_CHUNK = 1 << 16
_LINE = 300


def main() -> int:
    """Entry of `python -m gazechair.plugins.child JSON`: kind, name, entry, settings, how.

    `how`: "serve" the daemon; "paced": one step for each line with a time, for `plugin check`;
    "describe": only describe the plug-in.
    """
    argument = json.loads(sys.argv[1])
    out = enter_child()
    messages = os.dup(0)  # a plug-in that reads its standard input gets nothing
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    out.status("starting", STARTING, "starting")
    try:
        serve(argument, out, messages)
        return 0
    except BrokenPipeError:
        return 0
    except BadSetting as refused:
        out.status("lost", SETTING, str(refused)[:_LINE])
    except Unusable as error:
        out.status("lost", LOST, str(error)[:_LINE])
    except Exception as error:  # foreign code may raise anything; only its message matters
        sys.excepthook(type(error), error, error.__traceback__)
        line = f"{type(error).__name__}: {error}".partition("\n")[0]
        out.status("lost", RAISED, line[:_LINE])
    return 1


def serve(argument: dict[str, Any], out: RecordWriter, messages: int) -> None:
    """Serve until the parent closes the pipe, or the plug-in raises."""
    kind, how = argument["kind"], argument["how"]
    title = f"{kind}.{argument['name']}"
    found: Any = load(kind, argument["entry"])
    out.facts(facts(found).pack())
    if how == "describe":
        table = list(described(found.Settings, title))
        out.data(json.dumps({"table": table, "rehearsal": found.rehearsal}).encode())
        return
    plugin = build(found, title, argument["settings"])
    try:
        if how == "paced":
            _pace(plugin, out, messages)
        elif isinstance(plugin, Input):
            _serve_input(plugin, out)
        else:
            _serve_mode(plugin, out, messages)
    finally:
        plugin.close()


def _period_s(plugin: Any) -> float:
    return 1.0 / max(_RATES_HZ[0], min(float(plugin.rate_hz), _RATES_HZ[1]))


def _serve_input(plugin: Input, out: RecordWriter) -> None:
    caller = InputCaller(plugin)
    period_s = _period_s(plugin)
    while True:
        now_s = time.monotonic()
        out.data(caller.call(now_s).pack())
        fd = plugin.fileno()
        time.sleep(_LEAST_S if fd >= 0 else 0.0)
        left_s = max(0.0, now_s + period_s - time.monotonic())
        select.select([fd] if fd >= 0 else [], [], [], left_s)


def _serve_mode(plugin: Any, out: RecordWriter, messages: int) -> None:
    caller = ModeCaller(plugin)
    message: dict[str, Any] = {"press": 0, "state_s": 0.0}
    os.set_blocking(messages, False)
    lines = b""
    while True:
        out.data(caller.call(message, time.monotonic()).pack())
        message = {"press": 0, "state_s": 0.0}
        if messages not in select.select([messages], [], [], _IDLE_S)[0]:
            continue
        while True:  # read everything queued: only the newest line counts
            try:
                chunk = os.read(messages, _CHUNK)
            except BlockingIOError:
                break
            if not chunk:
                return
            lines += chunk
        *whole, lines = lines.split(b"\n")
        if whole:
            message = json.loads(whole[-1])


def _pace(plugin: Any, out: RecordWriter, messages: int) -> None:
    caller: Any = InputCaller(plugin) if isinstance(plugin, Input) else ModeCaller(plugin)
    with open(messages, "rb") as lines:
        for line in lines:
            message = json.loads(line)
            if isinstance(plugin, Input):
                value = caller.call(message["now_s"])
            else:
                value = caller.call(message, message["now_s"])
            out.data(value.pack())


if __name__ == "__main__":
    sys.exit(main())
