"""Plug-ins in the daemon: runs the enabled ones, each in a child process."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, Protocol

from gazechair.base import health as states
from gazechair.base.health import Health, HealthRegistry
from gazechair.base.latest_value import Clock
from gazechair.base.reasons import PARTS, PLUGIN
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.config.plugin_tables import PluginConfig
from gazechair.driving.mode_context import IDLE_LOOK_S, PRESSED_LOOK_S, ModeContext
from gazechair.plugins import value_checks
from gazechair.plugins.child import LOST, SETTING
from gazechair.plugins.exchange import LONGEST, RECORDS_PER_S, Facts, Value, plain, unpack_facts
from gazechair.plugins.found import find

MISSING = "plugin_missing"
_NICE = 5  # a busy plug-in must not take the processor from the parts that stop the chair
_LONGEST_PAUSE_S = 10.0
_OTHERS_S = 5.0  # longest wait for board, lidar and camera, which start first
_START_S = 2.0  # longest wait before the next plug-in starts
_HEALTH_S = 0.5
_DETAIL = 200
_WORLD_PERIOD_S = 0.018  # for 50 per second, with a margin


class Port(value_checks.Port, Protocol):
    """What plug-ins need from Control."""

    def offer_mode(self, mode: str, tile: dict[str, Any] | None) -> None: ...
    def mode_context(self) -> ModeContext: ...
    def show_plugins(self, rows: Callable[[], list[dict[str, Any]]]) -> None: ...


class Plugin(Supervised):
    """One enabled plug-in."""

    def __init__(self, config: PluginConfig, port: Port, health: Health, clock: Clock) -> None:
        self.config = config
        self._port = port
        self.health = health
        self._clock = clock
        self._life: value_checks.InputRun | value_checks.ModeRun | None = None
        self._facts = Facts("", "", {})
        self._reported_s = 0.0

    def start(self) -> None:
        """Start its process; a missing one is only reported in its health."""
        config = self.config
        try:
            found = find(config.kind, config.name)
        except LookupError as error:
            self.health.set(states.LOST, MISSING, f"{config.lines.get('', '')}: {error}")
            return
        argument = {
            "kind": config.kind,
            "name": config.name,
            "entry": found.entry,
            "settings": config.settings,
            "how": "serve",
        }
        self._supervisor = Supervisor(
            "gazechair.plugins.child",
            json.dumps(argument),
            self._on_data,
            self._on_status,
            lost_reason=LOST,
            silent_s=PARTS[PLUGIN].silent_s,
            listens=config.kind == "mode",
            name=self.health.name,
            longest=LONGEST,
            records_per_s=RECORDS_PER_S,
            on_facts=self._on_facts,
            longest_pause_s=_LONGEST_PAUSE_S,
            nice=_NICE,
        )
        self._supervisor.start()

    def stop(self) -> None:
        """End its process and its motion."""
        super().stop()
        self._end()

    def row(self) -> dict[str, Any]:
        """Its row for the pages; `again`: the token of the time of its restart."""
        now, again_s = self.health.now(), self.next_start_s
        return {
            "kind": self.config.kind,
            "name": self.config.name,
            "icon": self._facts.icon,
            "names": self._facts.names,
            "state": now.state,
            "reason": now.reason,
            "detail": plain(now.detail, _DETAIL),
            "again": None if again_s is None else self._port.proof(again_s),
        }

    def send(self, message: bytes) -> None:
        """Send the newest world to a mode."""
        if self._supervisor is not None:
            self._supervisor.send(message)

    def _on_facts(self, payload: bytes) -> None:
        self._facts = unpack_facts(payload)

    def _on_data(self, payload: bytes) -> None:
        if self._life is None:
            self._life = self._begin()
        try:
            value = self._life.take(payload)
        except ValueError:
            self._end()
            raise
        self._report(value)

    def _begin(self) -> value_checks.InputRun | value_checks.ModeRun:
        if self.config.kind == "input":
            return value_checks.InputRun(self._port, self.config.person, self._clock)
        tile = asdict(self._facts)
        del tile["about"]
        self._port.offer_mode(self.config.name, tile)
        auto = self._facts.auto
        return value_checks.ModeRun(self._port, self.config.name, self._clock, auto)

    def _end(self) -> None:
        life, self._life = self._life, None
        if isinstance(life, value_checks.InputRun):
            life.end()
        elif life is not None:
            self._port.offer_mode(self.config.name, None)

    def _report(self, value: Value) -> None:
        now_s = self._clock()
        if now_s < self._reported_s + _HEALTH_S and self.health.state in (
            states.OK,
            states.DEGRADED,
        ):
            return  # a plug-in that keeps changing must not fill the log
        self._reported_s = now_s
        if value.trouble:
            self.health.set(states.DEGRADED, "plugin_trouble", value.trouble)
        else:
            self.health.set(states.OK)

    def _on_status(self, status: Status) -> None:
        if status.state == states.LOST:
            self._end()
            detail = status.detail
            if status.reason == SETTING:
                detail = self.config.refusal(*detail.split(" ", 1))
            reason = f"plugin_{status.how}" if status.how else status.reason
            self.health.set(states.LOST, reason, detail)
        elif self._life is None and self.health.state != states.LOST:
            self.health.set(states.STARTING, status.reason, status.detail)


class Plugins:
    """All enabled plug-ins."""

    def __init__(
        self,
        configs: tuple[PluginConfig, ...],
        port: Port,
        parts: HealthRegistry,
        clock: Clock = time.monotonic,
    ) -> None:
        self._others = [parts.part(name) for name in parts.states()]
        self.running = {
            config.title: Plugin(config, port, parts.part(f"{config.kind} {config.name}"), clock)
            for config in configs
        }
        self._modes = {p.config.name: p for p in self.running.values() if p.config.kind == "mode"}
        port.show_plugins(self.rows)
        self._port = port
        self._clock = clock
        self._stopping = threading.Event()
        self._threads = [threading.Thread(target=self._send_worlds, name="modes", daemon=True)]

    def rows(self) -> list[dict[str, Any]]:
        """The rows of all for the pages."""
        return [plugin.row() for plugin in self.running.values()]

    def start(self, start: Callable[[Plugin, Health], None]) -> None:
        """Start each with `start`, which reports a failure in its health."""
        if not self._modes:
            self._threads.clear()
        if self.running:
            starter = threading.Thread(
                target=self._start, args=(start,), name="plugin-starts", daemon=True
            )
            self._threads.append(starter)
        for thread in self._threads:
            thread.start()

    def _start(self, start: Callable[[Plugin, Health], None]) -> None:
        # One after another: twenty processes starting at once would delay everything else.
        if not self._wait(self._others, _OTHERS_S):
            return
        for plugin in self.running.values():
            start(plugin, plugin.health)
            if not self._wait([plugin.health], _START_S):
                return

    def _wait(self, parts: list[Health], limit_s: float) -> bool:
        """Wait until none of `parts` is starting, at most `limit_s`; False when stopping."""
        end_s = self._clock() + limit_s
        while any(part.state == states.STARTING for part in parts) and self._clock() < end_s:
            if self._stopping.wait(IDLE_LOOK_S):
                return False
        return True

    def stop(self) -> None:
        """End all processes and threads."""
        self._stopping.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(5.0)
        for plugin in self.running.values():
            plugin.stop()

    def _send_worlds(self) -> None:
        sender = WorldSender()
        pause_s = IDLE_LOOK_S
        while not self._stopping.wait(pause_s):
            context = self._port.mode_context()
            message = sender.message(context, self._clock())
            if message is not None and context.mode in self._modes:
                self._modes[context.mode].send(message)
            pause_s = PRESSED_LOOK_S if context.mode else IDLE_LOOK_S


class WorldSender:
    """Decides what the pressed mode receives, and when: each new board state, 50 per second."""

    def __init__(self) -> None:
        self._sent_s = 0.0
        self._state_s = 0.0

    def message(self, context: ModeContext, now_s: float) -> bytes | None:
        """The next message; None: nothing to send now."""
        if not context.mode or context.state_s == self._state_s:
            return None
        if now_s - self._sent_s < _WORLD_PERIOD_S:
            return None
        self._sent_s, self._state_s = now_s, context.state_s
        return world_message(context)


def world_message(context: ModeContext) -> bytes:
    """The world as sent to a mode's process."""
    return json.dumps(
        {
            "press": context.press,
            "state_s": context.state_s,
            "heading_deg": context.heading_deg,
            "clearance": context.clearance,
            "view": context.view,
        }
    ).encode()
