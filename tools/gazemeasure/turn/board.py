"""The board's own motion code, driven tick by tick without its loops, for the turn benchmark."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gazeboard.core.limits import WIPER_NEUTRAL
from gazeboard.core.motion import Motion
from gazeboard.core.shared import Inputs
from gazeboard.io import joystick
from gazeboard.io.settings import Settings
from gazeboard.turning.turn import turn_controller
from gazelink import codes

_FREE = [1000] * 4  # no obstacle caps anything
_counts: Any = joystick.counts  # mypy has no types for functions that the board compiles


def settings_with(values: Mapping[str, int]) -> Any:
    """The board's Settings: the defaults, except `values` {name in the table: value}."""
    settings = Settings()
    for name, value in values.items():
        setattr(settings, name, value)
    return settings


class BoardMotion:
    """Motion and turn controller as the App builds them from these settings; no obstacles.

    `count` is the turn wiper. There is no safety core: everything is permitted.
    """

    def __init__(self, settings: Any) -> None:
        self.motion: Any = Motion(settings, turn_controller(settings))
        self.inputs = Inputs()
        self.inputs.cap_permille = 1000
        self.running = False
        self.end_reason = codes.NO_REASON
        self.count = WIPER_NEUTRAL
        self.linear_count = WIPER_NEUTRAL

    def sense(self, heading_q4: int, rate_q4: int) -> None:
        """A new sample of the heading sensor, 1/16 degree (0..5759) and 1/16 degree/s."""
        i = self.inputs
        i.heading_q4 = heading_q4
        i.rate_q4 = rate_q4
        i.heading_count = (i.heading_count + 1) & 0xFFFF

    def step_turn(self, verb: int) -> None:
        """A press: one step of the settings' step angle, codes.LEFT or RIGHT."""
        self._press(verb, codes.STEP, 0, 0)

    def pulse(self, turn_permille: int, pulse_ms: int) -> None:
        """A press: one tuning pulse, left positive."""
        verb = codes.LEFT if turn_permille > 0 else codes.RIGHT
        self._press(verb, codes.TUNE, turn_permille, pulse_ms)

    def _press(self, verb: int, mode: int, turn_permille: int, pulse_ms: int) -> None:
        i = self.inputs
        i.verb = verb
        i.mode = mode
        i.edge = i.edge % 255 + 1
        i.turn_permille = turn_permille
        i.pulse_ms = pulse_ms
        self.running = True

    def tick(self) -> None:
        """One millisecond."""
        motion = self.motion
        if self.running:
            motion.step(self.inputs, 0, _FREE)
            if motion.ended:
                self.running = False
                self.end_reason = motion.end_reason
        else:
            motion.stop()
        if motion.turn_permille or motion.linear_permille:
            self.count = _counts(motion.turn_permille, WIPER_NEUTRAL)
            self.linear_count = _counts(motion.linear_permille, WIPER_NEUTRAL)
        else:
            self.count = self.linear_count = WIPER_NEUTRAL
