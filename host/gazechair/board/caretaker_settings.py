"""The board settings that a caretaker may change from a phone while driving is off."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Sequence
from typing import Any

from gazechair.base.refused import Refused
from gazechair.board.setting_request import Link, ask
from gazelink import codes
from gazelink.settings_table import PROFILES, TABLE, index_of

# Speeds and distances. Safety settings (margins, limits, relay) are not for a phone.
ALLOWED = (
    "profile",
    "linear_permille",
    "turn_permille",
    "step_forward_ms",
    "step_turn_q4_deg",
    "step_turn_permille",
)
_ANSWER_S = 0.5
_TRIES = 2

Storing = contextlib.AbstractContextManager[bool]


class ChangeRefused(Refused):
    """Settings not read or changed.

    `unheard`: the board may have done it all the same, as its answer was lost."""

    def __init__(self, reason: str, detail: str, unheard: bool = False) -> None:
        super().__init__(reason, detail)
        self.unheard = unheard


class CaretakerSettings:
    """Thread-safe. Every method waits for the board, while that is silent a second a setting."""

    def __init__(
        self,
        link: Link,
        step_ms: Callable[[int, int, int], int | None] = lambda *_: None,
        storing: Callable[[], Storing] = lambda: contextlib.nullcontext(True),
    ) -> None:
        """`step_ms`: duration of a step forward for a row of PROFILES, `linear_permille` and
        `step_ramp_ms`; None: unchanged. `storing` prevents arming, see driving.storing."""
        self._link = link
        self._step_ms = step_ms
        self._storing = storing
        self._lock = threading.Lock()

    def read(self) -> dict[str, Any]:
        """{name: {"value", "low", "high", "default"}}, where each value has a name also "choices".

        Raises ChangeRefused.
        """
        with self._lock:
            return self._read()

    def change(self, values: dict[str, Any]) -> dict[str, Any]:
        """Set all `values` {name: whole number} and save them; returns as read().

        Everything is checked before anything changes. Raises ChangeRefused.
        """
        changes = [_checked(name, value) for name, value in values.items()]
        with self._lock:
            with self._storing() as nobody_drives:
                state = self._link.state()
                if not nobody_drives or (state is not None and state.state != codes.DISARMED):
                    raise ChangeRefused("setting_while_armed", "switch driving off first")
                if state is not None and state.faults >> codes.CALIBRATION & 1:
                    raise ChangeRefused("setting_by_calibration", "calibrate the joystick first")
                changes += self._step(values)
                if changes:
                    self._store(changes)
            return self._read()

    def _store(self, changes: list[tuple[int, int]]) -> None:
        """Set and save; what is not stored is set back, so that it does not stay in force."""
        before = [(index, self._ask(codes.SETTING_GET, index)) for index, _ in changes]
        changed, saving = 0, False
        try:
            for index, value in changes:
                changed += 1  # perhaps only the answer is lost
                self._ask(codes.SETTING_SET, index, value)
            saving = True
            self._ask(codes.SETTING_SAVE)
            if any(self._ask(codes.SETTING_GET, index) != value for index, value in changes):
                raise ChangeRefused("not_connected", "the board restarted before it saved", True)
        except ChangeRefused as refusal:
            if not saving and not refusal.unheard:
                changed -= 1
            self._put_back(before[:changed], saving and refusal.unheard)
            raise

    def _put_back(self, before: Sequence[tuple[int, int]], save: bool) -> None:
        """`save`: the new values may be in the flash. Half of the old ones must not get there."""
        for index, value in reversed(before):
            try:  # reported already; the page reads again
                self._ask(codes.SETTING_SET, index, value)
            except ChangeRefused:
                save = False
        if save:
            with contextlib.suppress(ChangeRefused):
                self._ask(codes.SETTING_SAVE)

    def _step(self, values: dict[str, Any]) -> list[tuple[int, int]]:
        """Keep the length of a step forward in another profile, or with another output."""
        if "step_forward_ms" in values or not {"profile", "linear_permille"} & set(values):
            return []
        names = ("profile", "linear_permille", "step_ramp_ms")
        now = {name: self._ask(codes.SETTING_GET, index_of(name)) for name in names}
        then = now | {name: values[name] for name in names if name in values}
        step_ms = None if then == now else self._step_ms(*then.values())
        return [] if step_ms is None else [(index_of("step_forward_ms"), step_ms)]

    def _read(self) -> dict[str, Any]:
        found: dict[str, dict[str, Any]] = {}
        for name in ALLOWED:
            _, default, low, high = TABLE[index_of(name)]
            value = self._ask(codes.SETTING_GET, index_of(name))
            found[name] = {"value": value, "low": low, "high": high, "default": default}
            if name == "profile":
                found[name]["choices"] = PROFILES
        return found

    def _ask(self, request: int, index: int = 0, value: int = 0) -> int:
        answer = ask(self._link, request, index, value, tries=_TRIES, answer_s=_ANSWER_S)
        if answer.value is not None:
            return answer.value
        if not answer.refused:
            raise ChangeRefused("not_connected", "the board does not answer", answer.unheard)
        name = str(codes.reason_name(answer.refused))
        detail = f"the board refuses {TABLE[index][0]}: {name}"
        raise ChangeRefused(name, detail, answer.unheard)


def _checked(name: str, value: object) -> tuple[int, int]:
    if name not in ALLOWED:
        known = ", ".join(ALLOWED)
        raise ChangeRefused("setting_unknown", f"no setting {name[:40]!r} here; there are {known}")
    index = index_of(name)
    _, _, low, high = TABLE[index]
    if type(value) is not int or not low <= value <= high:
        detail = f"{name} must be a whole number {low}..{high}"
        raise ChangeRefused("setting_out_of_range", detail)
    return index, value
