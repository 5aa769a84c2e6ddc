"""The pages' port during a first drive: adds the held button, and limits other pages."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.driving.control import Control
from gazechair.driving.driver_port import Message, RelayingPort
from gazechair.driving.messages import BadMessage, HoldBypass, parse
from gazechair.driving.refusal import Refusal, What
from gazechair.first_drive.guide import Guide, StepRefused
from gazechair.first_drive.held_button import Pressed
from gazelink import codes

_STOPS = ("stop", "disarm", "emergency", "release")
# What another page must not begin while a step moves the chair: it stops the step first.
_OTHERS: dict[object, What] = {
    "arm": "arm",
    "take": "take",
    "cmd": "cmd",
    "drive": "drive",
    "mode": "drive",
    "bypass": "bypass",
    "cap": "cap",
    "reset": "reset",
}
_ARMS = ("arm", "take")
_ONE_AT_A_TIME = (*_ARMS, "cap")  # and the beginning of a step
_MEANWHILE = "a caretaker is setting up the chair"
_STORING = "settings of the chair are being stored; try again"
_FULL_PERMILLE = 1000


class FirstDrivePort(RelayingPort):
    """The DriverPort of `control`, with {"k": "step"} added."""

    def __init__(self, control: Control, guide: Guide, facts: Callable[[], Message] = dict) -> None:
        """`facts`: additional fields for each state, from outside `control`."""
        super().__init__(control)
        self._control = control
        self._guide = guide
        self._facts = facts

    def disconnect(self, client: int) -> None:
        self._guide.held.release(client)
        super().disconnect(client)

    def receive(self, client: int, message: Message) -> list[Message]:
        kind = message.get("k")
        if kind == "step":
            refusal = self._hold(client, message)
            return [] if refusal is None else [refusal.message()]
        viewer = self._control.role(client) == "viewer"
        if kind in _STOPS and not viewer:
            self._guide.held.end()
        elif kind in _ONE_AT_A_TIME and not viewer:
            with self._guide.storing.arm() as may:
                if self._guide.moving:
                    return [Refusal(_OTHERS[kind], "not_owner", _MEANWHILE).message()]
                if kind in _ARMS and not may:
                    return [Refusal(_OTHERS[kind], "board_busy", _STORING).message()]
                return super().receive(client, message)
        elif self._guide.moving and kind in _OTHERS:
            return [Refusal(_OTHERS[kind], "not_owner", _MEANWHILE).message()]
        return super().receive(client, message)

    def snapshot(self, client: int) -> Message:
        state = super().snapshot(client) | self._facts()
        moving = self._guide.moving
        return {**state, "owner": "caretaker", "step": moving} if moving else {**state, "step": ""}

    def _hold(self, client: int, message: Message) -> Refusal | None:
        if self._control.role(client) != "caretaker":
            return Refusal("step", "not_allowed", "only the caretaker may")
        if message.get("held") is False:
            self._guide.held.release(client)
            return None
        try:
            # Pressed and proven like the bypass button.
            press = parse({**message, "k": "bypass"})
        except BadMessage as error:
            return Refusal("step", "bad_message", str(error))
        assert isinstance(press, HoldBypass)
        proven_s, fresh = self._control.proven(press.proof)
        if not fresh:
            self._guide.held.came_late(client, press.edge, proven_s)
            return Refusal("step", "stale_token", "the held button was too long on its way")
        pressed = self._guide.held.press(client, press.edge, proven_s)
        if pressed is Pressed.IN_VAIN:
            return Refusal("step", "first_busy", "somebody else holds a step's button")
        if pressed is Pressed.ANEW:
            try:
                self._begin(str(message.get("step")), client)
            except StepRefused as refused:
                self._guide.held.release(client)
                return Refusal("step", refused.reason, str(refused))
        return None

    def _begin(self, step: str, client: int) -> None:
        with self._guide.storing.arm() as may:
            state = self._control.snapshot(client)
            if state["owner"] != codes.OWNERS[codes.NOBODY]:
                # The board may not have armed for them yet.
                raise StepRefused("setting_while_armed")
            if step == "tune" and state["cap_permille"] < _FULL_PERMILLE:
                raise StepRefused("first_cap", "tuning turns the chair as fast as it can")
            if not may:
                raise StepRefused("board_busy", _STORING)
            # It must not change while the step moves the chair.
            self._guide.held.cap_permille = state["cap_permille"]
            self._guide.begin(step)
