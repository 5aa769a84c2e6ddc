"""Every fault that can be injected, by name, in one table."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Argument:
    """What a fault takes: a number within `low`..`high`, or a name when the default is one."""

    name: str
    default: float | str
    low: float = 0.0
    high: float = 0.0

    def refusal(self, value: object) -> str | None:
        """Why `value`, from anywhere, is none for it; None when it is one."""
        if isinstance(self.default, str):
            return None if isinstance(value, str) else "is not a name"
        if not isinstance(value, int | float) or isinstance(value, bool):
            return "is not a number"
        return None if self.low <= value <= self.high else f"is not within {self.low}..{self.high}"


@dataclass(frozen=True)
class Fault:
    """A fault: what it means, how to set and end it, the arguments it takes."""

    name: str
    meaning: str
    inject: Callable[..., None]  # (target, **arguments)
    clear: Callable[[Any], None] | None = None  # None: over as soon as it happened
    takes: tuple[Argument, ...] = ()


class Faults:
    """The faults of one target (a world, or a whole rig), by name."""

    def __init__(self, target: Any, table: Iterable[Fault]) -> None:
        self._known: dict[str, tuple[Any, Fault]] = {}
        self._active: dict[str, None] = {}  # in order of injection
        self.add(target, table)

    def add(self, target: Any, table: Iterable[Fault]) -> None:
        """Know the faults in `table` too, which act on `target`."""
        for fault in table:
            self._known[fault.name] = (target, fault)

    def names(self) -> list[str]:
        """All names that can be injected."""
        return sorted(self._known)

    def meanings(self) -> dict[str, str]:
        """What each fault means, by name."""
        return {name: self._known[name][1].meaning for name in self.names()}

    def active(self) -> list[str]:
        """Those injected and not cleared, oldest first."""
        return list(self._active)

    def inject(self, name: str, **arguments: float | str) -> None:
        """Set a fault; ValueError for an unknown name or a bad argument."""
        target, fault = self._find(name)
        known = {argument.name: argument for argument in fault.takes}
        values = {argument.name: argument.default for argument in fault.takes}
        for key, value in arguments.items():
            if key not in known:
                takes = ", ".join(known) or "no arguments"
                raise ValueError(f"fault {name} has no argument {key!r}; it takes {takes}")
            if refusal := known[key].refusal(value):
                raise ValueError(f"fault {name}: {key} {refusal}")
            values[key] = value
        fault.inject(target, **values)
        if fault.clear is not None:
            self._active[name] = None

    def clear(self, name: str) -> None:
        """End a fault, injected or not; ValueError for an unknown name."""
        target, fault = self._find(name)
        if fault.clear is not None:
            fault.clear(target)
        self._active.pop(name, None)

    def _find(self, name: str) -> tuple[Any, Fault]:
        if name not in self._known:
            raise ValueError(f"no fault {name!r}; there are {', '.join(self.names())}")
        return self._known[name]


WORLD_FAULTS = (
    Fault(
        "imu_freeze",
        "heading sensor answers, values stand still",
        lambda w: w.imu.set_frozen(True),
        lambda w: w.imu.set_frozen(False),
    ),
    Fault(
        "imu_spike",
        "every 1..3 s one heading is off",
        lambda w, spike_deg: w.imu.set_spike(spike_deg),
        lambda w: w.imu.set_spike(None),
        (Argument("spike_deg", 90.0, -180.0, 180.0),),
    ),
    Fault(
        "imu_self_reset",
        "heading sensor falls back to CONFIG, outputs zero",
        lambda w: w.imu.self_reset(),
    ),
    Fault(
        "imu_nak",
        "heading sensor answers nothing",
        lambda w: w.imu.set_nak(True),
        lambda w: w.imu.set_nak(False),
    ),
    Fault(
        "imu_jump",
        "heading is off from now on",
        lambda w, jump_deg: w.imu.jump(jump_deg),
        takes=(Argument("jump_deg", 30.0, -180.0, 180.0),),
    ),
    Fault(
        "imu_error",
        "heading sensor reports a system error",
        lambda w, code: w.imu.set_error(int(code)),
        lambda w: w.imu.set_error(0),
        (Argument("code", 3.0, 1.0, 10.0),),
    ),
    Fault(
        "imu_bus_stuck",
        "clock of the heading sensor's bus held low",
        lambda w: w.bank.stick_bus(1, True),
        lambda w: w.bank.stick_bus(1, False),
    ),
    Fault(
        "imu_stretch",
        "heading sensor holds the clock in every byte",
        lambda w, stretch_us: w.imu.set_stretch_us(int(stretch_us)),
        lambda w: w.imu.set_stretch_us(0),
        (Argument("stretch_us", 180.0, 0.0, 1e6),),
    ),
    Fault(
        "tilt",
        "the chair stands on a slope",
        lambda w, roll_deg, pitch_deg: w.imu.set_tilt(roll_deg, pitch_deg),
        lambda w: w.imu.set_tilt(0.0, 0.0),
        (Argument("roll_deg", 0.0, -90.0, 90.0), Argument("pitch_deg", 20.0, -90.0, 90.0)),
    ),
    Fault(
        "wiper_nak",
        "potentiometer answers nothing",
        lambda w: w.pot.set_nak(True),
        lambda w: w.pot.set_nak(False),
    ),
    Fault(
        "wiper_stuck",
        "potentiometer acknowledges, wipers stay",
        lambda w: w.pot.set_stuck(True),
        lambda w: w.pot.set_stuck(False),
    ),
    Fault(
        "joystick_stuck",
        "between wipers and chair something holds the turn axis deflected",
        lambda w, turn: setattr(w, "stuck_turn", turn),
        lambda w: setattr(w, "stuck_turn", None),
        (Argument("turn", 1.0, -1.0, 1.0),),
    ),
    Fault(
        "wiper_bus_stuck",
        "clock of the potentiometer's bus held low",
        lambda w: w.bank.stick_bus(0, True),
        lambda w: w.bank.stick_bus(0, False),
    ),
    Fault(
        "relay_stuck_closed",
        "relay contact welded",
        lambda w: w.relay.set_stuck(True),
        lambda w: w.relay.set_stuck(None),
    ),
    Fault(
        "relay_stuck_open",
        "relay contact never closes",
        lambda w: w.relay.set_stuck(False),
        lambda w: w.relay.set_stuck(None),
    ),
    Fault(
        "emergency",
        "emergency button pressed (input open)",
        lambda w: w.relay.press_emergency(True),
        lambda w: w.relay.press_emergency(False),
    ),
    Fault(
        "reset_button",
        "reset button at the chair held",
        lambda w: w.relay.press_button(True),
        lambda w: w.relay.press_button(False),
    ),
    Fault(
        "obstacle",
        "a box stands before the chair, distances from its axle",
        lambda w, **place: w.put_obstacle(**place),
        lambda w: w.room.put("obstacle", None),
        (
            Argument("ahead_m", 1.5, -20.0, 20.0),
            Argument("left_m", 0.0, -20.0, 20.0),
            Argument("size_m", 0.4, 0.05, 2.0),
        ),
    ),
    Fault(
        "door_closed",
        "a door of the room is closed",
        lambda w, door: w.room.set_door(door, False),
        lambda w: w.room.open_doors(),
        (Argument("door", "hallway"),),
    ),
)
