"""The gamepad as an input: turns stick, D-pad and buttons into intents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from gazechair.plugins import (
    NOTHING,
    STOP,
    Input,
    Intent,
    choice,
    drive,
    flag,
    hold,
    integer,
    number,
    setting,
    step,
    text,
)
from gazechair.plugins.gamepad import devices
from gazechair.plugins.gamepad.events import FIRST_BUTTONS, HAT_X, HAT_Y, RX, RY, PadState, X, Y

_LOOK_S = 1.0  # between two searches for a gamepad
_RELEASE = 0.7  # of the dead zone: hysteresis for a stick at its edge
_STICKS = {"left": (X, Y), "right": (RX, RY)}


class Gamepad(Input):
    """A USB gamepad or joystick at the host: stick, cross (steps), every button but one stops."""

    @dataclass(frozen=True)
    class Settings:
        """A gamepad or joystick at the host. `person` says whose it is."""

        device: str = setting(
            "auto", text(), '"auto" = the first there is, or a path as /dev/input/by-id/...'
        )
        stick: str = setting("left", choice(*_STICKS), "which stick drives")
        dead_zone_percent: int = setting(20, integer(5, 60), "dead zone around its middle")
        curve: float = setting(1.5, number(1.0, 3.0), "1 = even; more = finer near the middle")
        most_linear: int = setting(1000, integer(100, 1000), "permille at full push")
        most_turn: int = setting(700, integer(100, 1000), "permille at full push sideways")
        cross: str = setting("step", choice("step", "hold", "off"), "what the D-pad does")
        hold_button: bool = setting(
            False, flag(), "true = drives only while the first button (A, trigger) is pressed"
        )

    nl = "Joystick"
    en = "Joystick"
    icon = "🎮"
    rehearsal: ClassVar[Mapping[str, Any]] = {"device": devices.REHEARSAL}

    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        self._open = devices.opener(settings.device)
        self._pad: devices.Pad | None = None
        self._state = PadState({})
        self._look_s = -math.inf
        self._trouble = ""
        self._pushed = False
        self._rested = False  # since it was plugged in

    def fileno(self) -> int:
        """Readable when the person has moved something."""
        return -1 if self._pad is None else self._pad.fileno()

    def trouble(self) -> str:
        """Reports a missing gamepad."""
        return self._trouble

    def sense(self, now_s: float) -> Intent:
        """The intent of stick and buttons."""
        if self._pad is None and now_s - self._look_s >= _LOOK_S:
            self._look_s = now_s
            self._plug_in()
        if self._pad is None:
            return NOTHING
        try:
            self._state.feed(self._pad.read(now_s))
            if self._state.lost:
                self._read_again(self._pad)
        except OSError as error:
            self._unplug(str(error))
            return NOTHING
        intent = self._intent()
        self._rested = self._rested or intent == NOTHING
        return intent if self._rested or intent == STOP else NOTHING

    def _plug_in(self) -> None:
        try:
            self._pad = self._open()
            self._read_again(self._pad)
        except OSError as error:
            self._unplug(str(error))

    def _read_again(self, pad: devices.Pad) -> None:
        # The push of a stick that is already pushed was not seen: it must rest first.
        self._state = PadState(pad.ranges())
        for axis, value in pad.positions().items():
            self._state.put(axis, value)
        self._rested = False
        self._trouble = ""

    def _unplug(self, why: str) -> None:
        pad, self._pad = self._pad, None
        self._trouble = f"no gamepad: {why}"
        self._pushed = False
        if pad is not None:
            pad.close()

    def _intent(self) -> Intent:
        s, state = self.settings, self._state
        held = bool(state.buttons & set(FIRST_BUTTONS))
        if state.buttons - (set(FIRST_BUTTONS) if s.hold_button else set()):
            return STOP
        if s.hold_button and not held:
            return NOTHING
        if s.cross != "off" and (direction := self._cross()):
            return step(direction) if s.cross == "step" else hold(direction)
        return self._stick()

    def _cross(self) -> str:
        x, y = self._state.axes[HAT_X], self._state.axes[HAT_Y]
        if abs(y) > 0.5:
            return "forward" if y < 0 else "backward"
        return ("left" if x < 0 else "right") if abs(x) > 0.5 else ""

    def _stick(self) -> Intent:
        s = self.settings
        x, y = (self._state.axes[axis] for axis in _STICKS[s.stick])
        push, dead = math.hypot(x, y), s.dead_zone_percent / 100
        self._pushed = push > (dead * _RELEASE if self._pushed else dead)
        if not self._pushed:
            return NOTHING
        share = max(0.0, min((push - dead) / (1.0 - dead), 1.0)) ** s.curve / push
        return drive(round(-y * share * s.most_linear), round(-x * share * s.most_turn))
