"""The settings in force, as the board confirmed them to the fuzzer: what bounds its outputs."""

from __future__ import annotations

from typing import Any

from gazelink import codes
from gazelink.settings_table import NAMES, TABLE, profile_row

_DEFAULTS = {name: default for name, default, _, _ in TABLE}
_NEUTRAL = ("neutral_linear_count", "neutral_turn_count")
Counts = tuple[int, int]


class Rules:
    """What is in force and what is stored. A reset takes up what is stored."""

    linear_permille: int
    turn_permille: int
    step_turn_permille: int
    hold_permille: int
    step_forward_ms: int
    step_turn_limit_ms: int
    stop_margin_mm: int
    stop_margin_q4_deg: int
    supervision_ms: int
    auto_limit_s: int
    profile: int
    auto_permille: tuple[int, int, int, int]  # at most, however well the chair is known

    def __init__(self) -> None:
        self._stored: dict[str, int] = dict(_DEFAULTS)
        self._values = dict(_DEFAULTS)
        self.calibrated = True  # what is stored is not damaged
        self._came_up = True  # nor was it when the board came up, or it was saved since
        self._order = 0
        self._requested_at: dict[tuple[int, int], int] = {}  # request and index: when
        self._measured: dict[str, int] = {}  # counts of the neutral: when last asked for
        self.neutral: Counts = (170, 170)
        self.neutrals: list[Counts] = []  # that may be out while it is disarmed
        self._apply()

    def boot(self) -> None:
        """The board comes up with what is stored."""
        self._values = dict(self._stored)
        self._came_up = self.calibrated
        self._measured = {}
        self.neutrals = [(170, 170)]
        self._apply()

    def spoil(self, damaged: bool) -> None:
        """The file is gone, or `damaged`: the defaults, and no arming until a save."""
        self._stored = dict(_DEFAULTS)
        self.calibrated = not damaged

    def requested(self, fields: dict[str, Any]) -> None:
        """A request on its way: its neutral may be put out before its confirmation comes."""
        request, index = fields["request"], fields["index"]
        self._order += 1
        self._requested_at[request, index] = self._order
        if request == codes.SETTING_SET_NEUTRAL and index < len(NAMES):
            self._measured[NAMES[index]] = self._order
            tried = dict(self._values)
            tried[NAMES[index]] = fields["value"]
            self.neutrals.append((tried[_NEUTRAL[0]], tried[_NEUTRAL[1]]))

    def session(self) -> None:
        """Another session: a neutral that was not stored is forgotten."""
        self.neutrals.append(self.neutral)
        self._measured = {}
        for name in _NEUTRAL:
            self._values[name] = self._stored[name]
        self._apply()

    def confirmed(self, reply: dict[str, Any]) -> str:
        """The board's answer to a request; what was wrong with it, or ""."""
        request, index = reply["request"], reply["index"]
        if reply["refused"]:
            return ""
        if request in (codes.SETTING_SET, codes.SETTING_DEFAULTS):
            since = self._requested_at.get((request, index), 0)
            self._measured = {name: at for name, at in self._measured.items() if at > since}
        if request in (codes.SETTING_SET, codes.SETTING_SET_NEUTRAL):
            self._values[NAMES[index]] = reply["value"]
        elif request == codes.SETTING_DEFAULTS:
            kept = {name: self._values[name] for name in _NEUTRAL}
            self._values = {**_DEFAULTS, **kept}
        elif request == codes.SETTING_SAVE:
            guessed = not (self._came_up and self.neutral_stored) and len(self._measured) < 2
            self._stored = dict(self._values)
            self.calibrated = self._came_up = True
            if guessed:
                return "saved a neutral that nobody had just set"
        self._apply()
        return ""

    @property
    def neutral_stored(self) -> bool:
        """What is put out as neutral is what a reset would take up."""
        return all(self._values[name] == self._stored[name] for name in _NEUTRAL)

    def _apply(self) -> None:
        values = self._values
        self.neutral = (values[_NEUTRAL[0]], values[_NEUTRAL[1]])
        self.linear_permille = values["linear_permille"]
        self.turn_permille = values["turn_permille"]
        self.step_turn_permille = values["step_turn_permille"]
        self.hold_permille = values["hold_permille"]
        self.step_forward_ms = values["step_forward_ms"]
        self.step_turn_limit_ms = values["step_turn_limit_ms"]
        self.stop_margin_mm = values["stop_margin_mm"]
        self.stop_margin_q4_deg = values["stop_margin_q4_deg"]
        self.tilt_limit_deg = values["tilt_limit_q4_deg"] / 16
        self.supervision_ms = values["supervision_ms"]
        self.auto_limit_s = values["auto_limit_s"]
        self.profile = values["profile"]
        mm_s = values["auto_mm_s"]
        most = (mm_s, mm_s, mm_s * 917 // 750, mm_s * 917 // 750)  # the turn's at 0.75 m
        rows = ("forward_mm_s", "backward_mm_s", "left_q4_dps", "right_q4_dps")
        full = [values[profile_row(self.profile, row)] for row in rows]
        permille = [min(1000, m * 1000 // f) for m, f in zip(most, full, strict=True)]
        self.auto_permille = (permille[0], permille[1], permille[2], permille[3])
        self.relay_fitted = values["relay_fitted"] == 1
