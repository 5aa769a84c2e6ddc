"""Loads a plug-in in its own process, calls it, and turns its intent or output into a value."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from gazechair.config import tables
from gazechair.plugins.contract import NOTHING, Input, Intent, Mode, World, drive
from gazechair.plugins.exchange import WORLD_OLD_S, Facts, Value

# A step is repeated for this long, like a page's, so that a newer value does not hide it.
_STEP_REPEAT_S = 0.15
_KINDS: dict[str, type[Input] | type[Mode]] = {"input": Input, "mode": Mode}


def load(kind: str, entry: str) -> type[Input] | type[Mode]:
    """The class behind an entry point; raises whatever its import raises."""
    module, _, path = entry.partition(":")
    found: Any = importlib.import_module(module)
    for name in path.split("."):
        found = getattr(found, name)
    if not (isinstance(found, type) and issubclass(found, _KINDS[kind])):
        raise TypeError(f"{entry} is no {_KINDS[kind].__name__} of gazechair.plugins")
    return found


def build(plugin: type[Any], title: str, settings: Mapping[str, Any]) -> Any:
    """An instance with these settings. Raises tables.BadSetting, contract.Unusable."""
    return plugin(tables.read(plugin.Settings, settings, f"[{title}]"))


def facts(plugin: type[Any]) -> Facts:
    """The plug-in's description of itself."""
    about = (plugin.__doc__ or "").strip().partition("\n")[0]
    names = {"nl": plugin.nl[:20], "en": plugin.en[:20]}
    auto = issubclass(plugin, Mode) and plugin.auto
    return Facts(about[:200], plugin.icon[:4], names, auto)


class InputCaller:
    """Calls an input, and numbers its presses."""

    def __init__(self, plugin: Input) -> None:
        self._plugin = plugin
        self._sensed = NOTHING
        self._sent = NOTHING
        self._repeated_till_s = 0.0
        self._press = 0
        self._stops = 0

    def call(self, now_s: float) -> Value:
        """What its person wants now."""
        intent = self._plugin.sense(now_s)
        if not isinstance(intent, Intent):
            raise TypeError(f"sense() returned {intent!r}, which is no Intent")
        was, self._sensed = self._sensed, intent
        if intent.moves and (intent.do, intent.what) != (was.do, was.what):
            self._press += 1
            self._repeated_till_s = now_s + _STEP_REPEAT_S
        if intent.do == "stop" != was.do:
            self._stops += 1
        if not (intent == NOTHING and self._sent.do == "step" and now_s < self._repeated_till_s):
            self._sent = intent
        return Value(now_s, self._press, self._sent, self._stops, str(self._plugin.trouble()))


class ModeCaller:
    """Calls a mode with each world that is received."""

    def __init__(self, plugin: Mode) -> None:
        self._plugin = plugin
        self._press = 0
        self._since_s = 0.0

    def call(self, message: Mapping[str, Any], now_s: float) -> Value:
        """How it drives now.

        `message`: from the daemon's world_message(); press 0 when nobody presses the mode.
        """
        press, state_s = int(message["press"]), float(message["state_s"])
        trouble = str(self._plugin.trouble())
        if press != self._press:
            self._press, self._since_s = press, now_s
        if press == 0 or now_s - state_s > WORLD_OLD_S:
            return Value(now_s, 0, NOTHING, 0, trouble)
        pressed_s = now_s - self._since_s
        seen = message["heading_deg"], message["clearance"], message["view"]
        world = World(*seen, state_s, pressed_s)
        output = self._plugin.drive(world)
        intent = NOTHING if output is None else drive(*output)
        return Value(min(state_s, now_s), press, intent, 0, trouble)
