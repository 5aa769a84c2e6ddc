"""Autotune of a simulated chair: the host's own procedure on the board's own pulses."""

from __future__ import annotations

from typing import Any

from gazechair.tune.numbers import TurnNumbers
from gazechair.tune.procedure import Procedure
from gazechair.tune.recording import Recording, Sample
from gazelink import codes
from gazemeasure.turn_board import BoardMotion
from gazemeasure.turn_run import Bench
from gazesim.chair import Chair, Parameters
from gazesim.imu_model import Imu

_SAMPLE_MS = 10
_LIMIT_MS = 120_000


def record(chair: Chair, imu: Imu, settings: Any, profile: str) -> list[Recording]:
    """The procedure's recordings. TuneError when it gives up."""
    board = BoardMotion(settings)
    bench = Bench(chair, imu, board)
    procedure = Procedure(TurnNumbers.default(profile))
    held = None
    while not procedure.done:
        bench.run(_SAMPLE_MS)
        if bench.now_ms > _LIMIT_MS:
            raise AssertionError("the procedure does not end")
        reason = 0 if board.running else board.end_reason
        procedure.sample(Sample(bench.now_ms, imu.heading_q4 / 16, board.count, reason))
        bench.forget()
        if procedure.wanted is not held:
            held = procedure.wanted
            board.end_reason = codes.NO_REASON
            if held is None:
                board.running = False
            else:
                board.pulse(held.turn_permille, held.pulse_ms)
    return procedure.recordings


def truth(parameters: Parameters) -> TurnNumbers:
    """How that chair really turns, its casters aside."""
    axis = parameters.disturbances.axis(parameters.turn)
    return TurnNumbers(
        axis.positive,
        axis.negative,
        axis.deadband,
        axis.dead_time_s,
        axis.lag_s,
        axis.accelerate,
        axis.brake,
        axis.stiction,
    )
