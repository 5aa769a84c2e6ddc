"""Autotune of a simulated chair: the host's own procedure on the board's own pulses."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from gazeboard.core.limits import WIPER_NEUTRAL
from gazeboard.io.joystick import permille
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.procedure import Procedure
from gazechair.commissioning.tune.recording import Recording, Sample
from gazelink import codes
from gazemeasure.turn.board import BoardMotion
from gazemeasure.turn.run import Bench
from gazesim.board_limits import LIMITS
from gazesim.chair import Chair, Parameters
from gazesim.imu_model import Imu

_SAMPLE_MS = 10
_LIMIT_MS = 120_000


def waits_ms(seed: int) -> Iterator[int]:
    """Delays from a sample until its pulse begins: a command reaches the board at any time between
    two samples."""
    source = random.Random(seed)
    while True:
        yield source.randint(1, _SAMPLE_MS - 1)


def record(chair: Chair, imu: Imu, settings: Any, profile: str, seed: int = 1) -> list[Recording]:
    """The procedure's recordings; `seed` draws when pulses begin. TuneError when it gives up."""
    board = BoardMotion(settings)
    bench = Bench(chair, imu, board)
    procedure = Procedure(TurnNumbers.default(profile), WIPER_NEUTRAL, LIMITS)
    held = None
    waits = waits_ms(seed)
    wait_ms = 0
    while not procedure.done:
        bench.run(wait_ms)
        if wait_ms:
            assert held is not None
            board.pulse(held.turn_permille, held.pulse_ms)
        bench.run(_SAMPLE_MS - wait_ms)
        wait_ms = 0
        if bench.now_ms > _LIMIT_MS:
            raise AssertionError("the procedure does not end")
        reason = 0 if board.running else board.end_reason
        out = permille(board.count, WIPER_NEUTRAL)
        procedure.sample(Sample(bench.now_ms, imu.heading_q4 / 16, out, reason))
        bench.forget()
        if procedure.wanted is not held:
            held = procedure.wanted
            board.end_reason = codes.NO_REASON
            if held is None:
                board.running = False
            else:
                wait_ms = next(waits)
    return procedure.recordings


def truth(parameters: Parameters) -> TurnNumbers:
    """The chair's true numbers, without its casters."""
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
