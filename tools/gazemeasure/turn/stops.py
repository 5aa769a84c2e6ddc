"""Interrupts a turn by every possible cause, through the whole firmware: neutral at once.

In a step turn, a continuous turn and a tuning pulse, at several moments of each, something ends it.
From the tick in which the safety core no longer permits the motion both wipers must read neutral
(or, when the potentiometer fails, the enable line must be off), and stay so for a second although
the same press stays active. For Stop itself the tick counts in which its frame is decoded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gazeboard.core import limits
from gazelink import codes
from gazesim.chair_rig import LinkedChair

MOMENTS_MS = (250, 60, 480)  # from the press until it is cut short
_WAIT_MS = 700  # the slowest cause takes 500 ms
_STAYS_MS = 1000
# (mode, turn permille, pulse ms)
_MOTIONS = ((codes.STEP, 0, 0), (codes.CONTINUOUS, 0, 0), (codes.TUNE, -1000, 900))
_LEFT, _RIGHT = 1 << codes.DIR_LEFT, 1 << codes.DIR_RIGHT


@dataclass
class Stops:
    """The observations on all paths."""

    paths: int = 0
    not_neutral: int = 0
    """Ticks without permission in which a wiper was not neutral and the enable line on."""
    worst_stop_ticks: int = 0
    """From the decoding of Stop to neutral."""
    never: int = 0
    """Paths whose cause did not end the motion."""
    lowest: int = 255
    highest: int = 0


def _set(name: str, value: object) -> Callable[[LinkedChair], None]:
    return lambda chair: setattr(chair, name, value)


def _fault(name: str) -> Callable[[LinkedChair], None]:
    return lambda chair: chair.world.faults.inject(name)


def _order(action: int, owner: int) -> Callable[[LinkedChair], None]:
    return lambda chair: chair.link.order(action, owner)


def _raise(chair: LinkedChair) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("injected")

    chair.app.motion.step = broken


def _stall(chair: LinkedChair) -> None:
    chair.board.clock.now_us += 30_000  # the tick's own clock jumps


CAUSES: dict[str, Callable[[LinkedChair], None]] = {
    "stop": LinkedChair.release,
    "hold not proven": _set("holds", False),
    "host silent": lambda chair: setattr(chair.link, "alive", False),
    "obstacle": _set("blocked", _LEFT | _RIGHT),
    "no obstacle data": _set("sees", False),
    "disarm": _order(codes.DISARM, codes.CARETAKER),
    "emergency message": _order(codes.EMERGENCY_STOP, codes.DRIVER),
    "another owner": _order(codes.ARM, codes.DRIVER),
    "another host": lambda chair: chair.link.protocol.opened(chair.now_s()),
    "service loop hangs": lambda chair: setattr(chair.board, "blocked", True),
    "tick raises": _raise,
    "tick stalls": _stall,
    "relay opens": _fault("relay_stuck_open"),
    **{
        name.replace("_", " "): _fault(name)
        for name in (
            # No wiper_stuck: it shows when another value is written, so it ends no motion.
            *("emergency", "tilt", "wiper_nak", "wiper_bus_stuck", "imu_freeze"),
            *("imu_nak", "imu_jump", "imu_error", "imu_self_reset", "imu_bus_stuck"),
        )
    },
}
_STEP_GOES_ON = ("hold not proven",)  # a step needs no holding: it ends by itself


def stop_paths(moment_ms: int, only_one_motion: bool) -> Stops:
    """Walk all paths that are interrupted `moment_ms` after the press; in every motion, or, to be
    quick, in one motion per cause, in turn."""
    stops = Stops()
    for number, (name, strike) in enumerate(CAUSES.items()):
        motions = _MOTIONS[number % 3 :][:1] if only_one_motion else _MOTIONS
        for mode, permille, pulse_ms in motions:
            if mode != codes.STEP or name not in _STEP_GOES_ON:
                chair = LinkedChair()
                chair.board.watchdog = False  # the firmware must end it without the watchdog
                chair.arm()
                chair.press(
                    codes.RIGHT if mode == codes.TUNE else codes.LEFT, mode, permille, pulse_ms
                )
                _path(chair, stops, strike, moment_ms, name == "stop")
    return stops


def together(parts: Sequence[Stops]) -> Stops:
    """The sum of the parts."""
    return Stops(
        sum(p.paths for p in parts),
        sum(p.not_neutral for p in parts),
        max(p.worst_stop_ticks for p in parts),
        sum(p.never for p in parts),
        min(p.lowest for p in parts),
        max(p.highest for p in parts),
    )


def _path(
    chair: LinkedChair,
    stops: Stops,
    strike: Callable[[LinkedChair], None],
    moment_ms: int,
    is_stop: bool,
) -> None:
    stops.paths += 1
    for _ in range(moment_ms):
        _tick(chair, stops)
    strike(chair)
    decoded = chair.app.inbox.back.stop_count
    waited, since_stop = 0, 0
    while chair.app.safety.permitted and waited < _WAIT_MS:
        since_stop += chair.app.inbox.back.stop_count != decoded
        _tick(chair, stops)
        waited += 1
    if chair.app.safety.permitted:
        stops.never += 1
        return
    if is_stop:
        stops.worst_stop_ticks = max(stops.worst_stop_ticks, since_stop)
    for _ in range(_STAYS_MS):
        _tick(chair, stops)


def _tick(chair: LinkedChair, stops: Stops) -> None:
    chair.one_ms()
    safety = chair.app.safety
    if not safety.permitted and safety.enable and not chair.neutral():
        stops.not_neutral += 1
    if chair.app.joystick.linear_wiper != limits.WIPER_NEUTRAL:
        stops.not_neutral += 1  # turning never drives
    stops.lowest = min(stops.lowest, chair.app.joystick.turn_wiper)
    stops.highest = max(stops.highest, chair.app.joystick.turn_wiper)
