"""Runs one turn: a controller at 1 kHz, the chair's twin, the heading sensor at 100 Hz."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from gazeboard.core.limits import HEADING_TURN_Q4_DEG, WIPER_NEUTRAL
from gazelink import codes
from gazemeasure.turn.board import BoardMotion
from gazemeasure.turn.judge import Turn
from gazesim.chair import Chair
from gazesim.imu_model import Imu
from gazesim.pot import deflection

WARM_MS = 50  # until the chair has seen a neutral joystick and the sensor's pipeline is full
_BETWEEN_MS = 500
_STICK = [deflection(count) for count in range(256)]


class Controller(Protocol):
    """Turns the chair with its wiper."""

    count: int
    running: bool

    def sense(self, heading_q4: int, rate_q4: int) -> None:
        """A sample of the heading sensor."""

    def tick(self) -> None:
        """One millisecond."""


class Bench:
    """A chair with its sensor and a controller on it, time in whole milliseconds."""

    def __init__(self, chair: Chair, imu: Imu, controller: Controller) -> None:
        self.chair = chair
        self.now_ms = 0
        self.headings: list[float] = []
        self.rates: list[float] = []
        self.counts: list[int] = []
        self.imu = imu
        self._controller = controller

    def run(self, ms: int, watch: Callable[[], bool] = lambda: False) -> None:
        """Run for `ms`, recording, or until `watch`, called with each sample, returns true."""
        chair, controller, imu = self.chair, self._controller, self.imu
        for _ in range(ms):
            if imu.step(0.001, chair.yaw_rate_deg_s):
                controller.sense(imu.heading_q4 % HEADING_TURN_Q4_DEG, imu.rate_q4)
                if watch():
                    return
            controller.tick()
            count = controller.count
            chair.step(0.001, (_STICK[WIPER_NEUTRAL], _STICK[count]))
            self.headings.append(chair.heading_deg)
            self.rates.append(chair.yaw_rate_deg_s)
            self.counts.append(count)
            self.now_ms += 1

    def forget(self) -> None:
        """Discard the recording."""
        self.headings.clear()
        self.rates.clear()
        self.counts.clear()


def turn_of_board(
    chair: Chair, imu: Imu, settings: Any, angle_deg: float, after_ms: int = 1500
) -> Turn:
    """One step turn of the board's own controller; recorded until `after_ms` past its end."""
    settings.step_turn_q4_deg = round(abs(angle_deg) * 16)
    board = BoardMotion(settings)
    bench = Bench(chair, imu, board)
    bench.run(WARM_MS)
    before_deg = chair.heading_deg
    bench.forget()
    board.step_turn(codes.LEFT if angle_deg > 0 else codes.RIGHT)
    bench.run(settings.step_turn_limit_ms + 1, lambda: not board.running)
    bench.run(after_ms)
    return recorded(bench, angle_deg, before_deg)


def steps_of_board(
    chair: Chair, imu: Imu, settings: Any, angle_deg: float, count: int
) -> tuple[float, float]:
    """`count` step turns, each pressed half a second after the one before has ended. Returns the
    total turn by the heading sensor, and the true one, degrees."""
    settings.step_turn_q4_deg = round(abs(angle_deg) * 16)
    board = BoardMotion(settings)
    bench = Bench(chair, imu, board)
    bench.run(WARM_MS)
    shown_deg, true_deg = imu.heading_deg, chair.heading_deg
    for _ in range(count):
        board.step_turn(codes.LEFT if angle_deg > 0 else codes.RIGHT)
        bench.run(settings.step_turn_limit_ms + 1, lambda: not board.running)
        bench.run(_BETWEEN_MS)
        bench.forget()
    return imu.heading_deg - shown_deg, chair.heading_deg - true_deg


def recorded(bench: Bench, angle_deg: float, before_deg: float) -> Turn:
    """The bench's recording, as a turn that began at `before_deg`."""
    return Turn(
        angle_deg,
        np.array(bench.headings) - before_deg,
        np.array(bench.rates),
        np.array(bench.counts, np.int16),
    )
