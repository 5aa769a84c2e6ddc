"""The virtual chair with a host, its driver's page, and a seat for one plug-in, in virtual time.

The seat treats the plug-in like gazechair.plugins.service treats a process: its values pass through
the same run, and a refused one ends it.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any
from unittest import mock

from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Clearance
from gazechair.config.settings import Config
from gazechair.driving.arbiter import LOOK_S
from gazechair.driving.control import Control
from gazechair.plugins.exchange import BadValue, Value, unpack
from gazechair.plugins.service import world_message
from gazechair.plugins.value_checks import InputRun, ModeRun
from gazelink import codes
from gazesim.chair_rig import CLEARANCE_MS, ChairRig
from gazesim.lockstep_link import LockstepLink

_ASK_MS = 20
_UPDATE_MS = round(1000 * LOOK_S)
_BEAT_MS = 100
_READY_MS = 8000
_ALL = 0b1111  # every direction
Say = Callable[[dict[str, Any]], bytes | None]


class PluginChair(ChairRig):
    """`say` is the plug-in: takes a word, returns the value that it answers; None: nothing."""

    def __init__(self, kind: str, name: str, say: Say) -> None:
        super().__init__("open")
        self.link = LockstepLink(self.cable, self.now_s, iter(range(7, 9999)).__next__)
        parts = HealthRegistry(self.now_s)
        for part in ("board", "lidar", "camera"):
            parts.part(part).set(OK)
        with mock.patch("secrets.randbelow", random.Random(1).randrange):
            self.control = Control(Config(), self.link, parts, clock=self.now_s)
        self.page = self.control.connect("driver")
        self.blocked = 0
        self.sees = True
        self.kind = kind
        self._name = name
        self._say = say
        self._life: InputRun | ModeRun | None = None
        self._pressed = False
        self._edge = 0
        self.spoil: Callable[[Value], bytes | None] = Value.pack
        """Changes a value on its way; returns None if it never arrives."""
        self.value: Value | None = None
        """The plug-in's newest value, arrived or not."""
        self.refused = ""
        """Why the seat ended the plug-in."""
        self.reasons: set[str] = set()
        """Why the page's or the plug-in's presses were refused."""

    # -- the plug-in's life --

    def sit(self) -> None:
        """The plug-in's process starts."""
        self.refused = ""
        if self.kind == "input":
            self._life = InputRun(self.control, "driver", self.now_s)
        else:
            self._life = ModeRun(self.control, self._name, self.now_s)
            self.control.offer_mode(self._name, {"icon": "", "names": {}})

    def leave(self) -> None:
        """It ends, for any reason."""
        if isinstance(self._life, InputRun):
            self._life.end()
        elif self._life is not None:
            self.control.offer_mode(self._name, None)
        self._life = None

    def _ask(self) -> None:
        message = json.loads(world_message(self.control.mode_context()))
        if self.control.mode_context().mode != self._name:
            message["press"] = 0
        payload = self._say({**message, "now_s": self.now_s()})
        if payload is None:
            return
        try:
            self.value = unpack(payload)
            payload = self.spoil(self.value)
            if payload is not None and self._life is not None:
                self._life.take(payload)
                if isinstance(self._life, InputRun) and self._life.refused:
                    self.reasons.add(self._life.refused)
        except BadValue as error:
            self.refused = str(error)
            self.leave()

    # -- everybody else --

    def host_ms(self) -> None:
        """Link, page, lidar, then the plug-in."""
        self.link.one_ms()
        now_s = self.now_s()
        if self.now_ms % CLEARANCE_MS == 0 and self.sees:
            far = (3000, 2000, 1440, 1440)  # mm, 1/16 degree
            acquired_s = now_s - 0.02
            self.control.clearance(Clearance(self.blocked, codes.SIMULATED, acquired_s, 0, *far))
        if self.now_ms % _UPDATE_MS == 0:
            self.control.update()
            if self._pressed:
                self.say(k="mode", mode=self._name, edge=self._edge)
        if self.now_ms % _BEAT_MS == 0:
            self.say(k="hb")
        if self.now_ms % _ASK_MS == 0:
            self._ask()

    def say(self, **message: Any) -> None:
        """The driver's page sends this, with a fresh token."""
        token = self.control.token()
        for refusal in self.control.receive(self.page, {**message, "token": token}):
            self.reasons.add(refusal["reason"])

    def press(self) -> None:
        """The driver's page holds the mode's tile."""
        self._edge += 1
        self._pressed = self.kind == "mode"

    def release(self) -> None:
        """The driver's page releases it."""
        self._pressed = False
        if self.kind == "mode":
            self.say(k="stop")

    def block(self, on: bool) -> None:
        """Puts an obstacle in every direction, or removes it."""
        self.blocked = _ALL if on else 0

    def ready(self) -> None:
        """Wait until nothing prevents arming."""
        self.until(lambda: self.app is not None and self.link.state() is not None, _READY_MS)
        self.until(lambda: bool(self.app.safety.arm_reason == codes.NO_REASON), _READY_MS)

    def arm(self) -> None:
        """Arm from the driver's page, with all directions free."""
        self.ready()
        self.say(k="arm")
        self.until(self.armed, 1000)
        self.until(lambda: not self.app.obstacles.blocked, 1000)
