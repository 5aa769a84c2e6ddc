"""The controllers for comparison: the first prototype's PID and a plain tuned one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from gazeboard.core.limits import WIPER_NEUTRAL
from gazeboard.io.joystick import counts
from gazeboard.turning.pid import PID
from gazemeasure.turn.judge import Turn
from gazemeasure.turn.run import WARM_MS, Bench, recorded
from gazesim.chair import Chair
from gazesim.imu_model import Imu
from gazetwin.prototype import PUBLISHED, Prototype, Reading


class Rival(ABC):
    """A controller for Bench that keeps neutral until `start`."""

    def __init__(self) -> None:
        self.count = WIPER_NEUTRAL
        self.running = False
        self._heading_q4 = 0
        self._rate_q4 = 0
        self._setpoint_q4 = 0
        self._turned_q4 = 0
        self._now_ms = 0

    def start(self, angle_deg: float) -> None:
        """Turn by `angle_deg` from here, left positive."""
        self.running = True
        self._turned_q4 = 0
        self._setpoint_q4 = round(angle_deg * 16)
        self._now_ms = 0

    @abstractmethod
    def tick(self) -> None:
        """See run.Controller."""

    def sense(self, heading_q4: int, rate_q4: int) -> None:
        """See run.Controller."""
        self._turned_q4 += (heading_q4 - self._heading_q4 + 2880) % 5760 - 2880
        self._heading_q4 = heading_q4
        self._rate_q4 = rate_q4


class PrototypeTurn(Rival):
    """The first prototype's controller, with one interpretation of its published gains."""

    def __init__(self, reading: Reading) -> None:
        super().__init__()
        self._reading = reading
        self._every_ms = 1000 // reading.rate_hz

    def start(self, angle_deg: float) -> None:
        """See Rival."""
        super().start(angle_deg)
        self._controller = Prototype(self._reading, PUBLISHED, angle_deg)

    def tick(self) -> None:
        """See run.Controller."""
        if self.running and self._now_ms % self._every_ms == 0:
            self.count = self._controller.update(self._turned_q4 / 16)
        self._now_ms += 1


@dataclass(frozen=True)
class PlainGains:
    """Gains of `turning.pid`: permille per degree, per degree second, per degree/s; sixteenths."""

    kp_q4: int
    ki_q4: int
    kd_q4: int
    cutoff_q4: int
    """Within this distance of the setpoint the output is neutral, 1/16 degree."""


class PlainTurn(Rival):
    """A PID on the heading error only; the board's own PID, every ms."""

    def __init__(self, gains: PlainGains) -> None:
        super().__init__()
        self._gains = gains

    def start(self, angle_deg: float) -> None:
        """See Rival."""
        super().start(angle_deg)
        g = self._gains
        self._pid = PID(g.kp_q4, g.ki_q4, g.kd_q4)

    def tick(self) -> None:
        """See run.Controller."""
        if not self.running:
            return
        error_q4 = self._setpoint_q4 - self._turned_q4
        out = self._pid.update(error_q4, self._rate_q4, 1)
        if abs(error_q4) <= self._gains.cutoff_q4:
            out = 0
        self.count = counts(out, WIPER_NEUTRAL)


def turn_of_rival(chair: Chair, imu: Imu, rival: Rival, angle_deg: float, seconds: float) -> Turn:
    """One turn, recorded for `seconds`, because rivals do not end by themselves."""
    bench = Bench(chair, imu, rival)
    bench.run(WARM_MS)
    before_deg = chair.heading_deg
    bench.forget()
    rival.start(angle_deg)
    bench.run(round(seconds * 1000))
    return recorded(bench, angle_deg, before_deg)
