"""The chair under the fuzzed board, and what its heading sensor makes of it.

A dead time, a deadband and a lag; no faster than the fastest profile. Not a chair to measure
anything with: it only has to answer the joystick as a chair does.
"""

from __future__ import annotations

import random
import struct

from gazeprove.fuzz_board import World

PERIOD_US = 10_000
_DEAD = 14  # periods from the wipers to the wheels
_DEADBAND = 56
_FASTEST_DPS = 45.0
_LAG = 10 / 350
_SPAN = 84
_TURNS_DPS = 12  # more than a chair that should stand does by itself


class Chair:
    """Wipers in, sensor registers out, once every 10 ms. The sensor's faults are switched here."""

    def __init__(self, world: World, rng: random.Random) -> None:
        self._world = world
        self._rng = rng
        self._history = [0] * _DEAD
        self._at = 0
        self.neutral_turn = 170
        self.obeys = True
        self.rate_dps = 0.0
        self.heading_deg = rng.uniform(0, 360)
        self.pushed_dps = 0.0  # by whatever is not the joystick
        self.tilt_deg = 0.0
        # When each began, in the world's microseconds; -1: it is not so.
        self.frozen_us = -1
        self.tilted_us = -1
        self.unfit_us = -1  # not in a mode that measures
        self.fit_us = -1  # in one again
        self.jumped_us = -1
        self.turned_us = -1  # turning, all the time in one sense
        self._turns = 0
        self.offset_deg = 0.0
        self.spike_deg = 0.0
        self._written = bytes(8)

    def freeze(self) -> None:
        """The sensor's data stop changing."""
        self.frozen_us = self._world.now_us

    def thaw(self) -> None:
        """They change again."""
        self.frozen_us = -1
        self.turned_us = -1  # nobody can tell since when

    def jump(self, degrees: float) -> None:
        """The heading is another from now on."""
        self.offset_deg += degrees
        self.jumped_us = self._world.now_us

    def tilt(self, degrees: float, limit_deg: float) -> None:
        """The chair stands askew."""
        self.tilt_deg = degrees
        if abs(degrees) <= limit_deg:
            self.tilted_us = -1
        elif self.tilted_us < 0:
            self.tilted_us = self._world.now_us

    def step(self, driven: bool) -> None:
        """10 ms. `driven`: the chair listens to the joystick (its relay is closed)."""
        world = self._world
        permille = (world.pot.registers[1] - self.neutral_turn) * 1000 // _SPAN if driven else 0
        at = self._at
        late = self._history[at]
        self._history[at] = permille
        self._at = (at + 1) % _DEAD
        size = abs(late) - _DEADBAND
        wanted = size * _FASTEST_DPS / (1000 - _DEADBAND) if size > 0 and self.obeys else 0.0
        self.rate_dps += ((wanted if late > 0 else -wanted) - self.rate_dps) * _LAG
        rate = self.rate_dps + self.pushed_dps
        turns = (rate > _TURNS_DPS) - (rate < -_TURNS_DPS)
        if turns != self._turns or not turns or self.jumped_us >= world.now_us - PERIOD_US:
            self.turned_us = world.now_us if turns else -1
        self._turns = turns
        self.heading_deg += rate / 100
        registers = world.imu.registers
        if registers[0x3D] != 0x08:
            if self.unfit_us < 0:
                self.unfit_us = world.now_us
            return
        if self.unfit_us >= 0:
            self.unfit_us = -1
            self.fit_us = world.now_us
        registers[0x35] = 0x3C
        registers[0x39] = 5
        if self.frozen_us >= 0:
            return
        noise = self._rng.getrandbits(6)
        clockwise = -(self.heading_deg + self.offset_deg + self.spike_deg)
        self.spike_deg = 0.0
        burst = struct.pack(
            "<4h",
            (noise & 7) - 4,
            (noise >> 3) - 4,
            int(rate * 16) + (noise & 1),
            int(clockwise * 16) % 5760,
        )
        if burst == self._written:
            burst = struct.pack("<h", (noise & 7) - 5) + burst[2:]
        self._written = burst
        registers[0x14:0x1C] = burst
        struct.pack_into("<h", registers, 0x1C, int(self.tilt_deg * 16))
