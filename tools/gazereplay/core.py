"""The board's core with its parts, fed by a trace."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.safety import Safety
from gazeboard.core.shared import Inputs
from gazeboard.core.tick import Tick
from gazeboard.core.tick_clock import TickClock
from gazeboard.io.core_state import CoreState
from gazeboard.io.joystick import Joystick
from gazeboard.io.settings import Settings
from gazeboard.turning.casters import Casters
from gazeboard.turning.turn import turn_controller
from gazelink.settings_table import NAMES, NO_CASTERS_Q4_DEG, PROFILES, profile_row
from gazereplay import trace

_CASTERS = f"{Casters.__name__} "


class _Wipers:
    """An I2C bus whose potentiometer answers."""

    def writeto(self, _address: int, _octets: bytes) -> None:
        """Nothing is there."""

    def readfrom_into(self, _address: int, octets: bytearray) -> None:
        """Nothing is there."""


def _places(state: CoreState) -> Iterator[tuple[str, Any, str | int]]:
    """Each word after the settings: its unique name, and where it is."""
    kinds: dict[str, list[Any]] = {}
    arrays: dict[int, str] = {}

    def name_of(part: Any, key: str) -> str:
        alike = kinds.setdefault(type(part).__name__, [])
        if not any(part is one for one in alike):
            alike.append(part)
        at = next(k for k, one in enumerate(alike) if one is part)
        return f"{type(part).__name__} {at} {key}"

    for part, key in state.numbers:
        yield name_of(part, key), part, key
    for part in state._found:
        for key, value in sorted(vars(part).items()):
            arrays.setdefault(id(value), name_of(part, key))
    for numbers in (*state.lists, *state.arrays):
        for k in range(len(numbers)):
            yield f"{arrays[id(numbers)]} {k}/{len(numbers)}", numbers, k


class Core:
    """The board's core with its parts, as gazeboard.app has them."""

    def __init__(
        self, settings: Settings, simulated: bool, boot_faults: int, clock: Any = None
    ) -> None:
        """`clock`: replaces a TickClock."""
        s: Any = settings
        self._neutral: tuple[int, int] | None = None
        self.inputs = Inputs()
        self._obstacles = Obstacles(s)
        self._obedience = Obedience(s)
        safety = Safety(simulated, s.relay_fitted, boot_faults)
        self.stick: Any = Joystick(_Wipers())
        self._tick = Tick(
            safety, None, self._obstacles, self._obedience, None, clock or TickClock()
        )
        self.apply(settings)

    def apply(self, settings: Settings) -> None:
        """Apply other settings, while disarmed."""
        s: Any = settings
        safety = self._tick.safety
        if s.neutral() != self._neutral:
            self._neutral = s.neutral()
            self.stick.set_neutral(*s.neutral())
            safety.neutral_moved()
        self._obstacles.configure(s)
        self._obedience.configure(s)
        turn = turn_controller(s)
        self._tick.motion = Motion(s, turn)
        self._tick.profile_check = ProfileCheck(turn.model)
        safety.set_relay_fitted(s.relay_fitted)

    def layout(self) -> list[str]:
        """The name of each word of a CoreState."""
        state = CoreState(self._tick, self.stick, Settings())
        return [*NAMES, *(name for name, _, _ in _places(state))]

    def restore(self, words: Mapping[str, int]) -> None:
        """Restore the words of a CoreState by the layout's names; missing ones stay."""
        for name, target, key in _places(CoreState(self._tick, self.stick, Settings())):
            if name not in words:
                continue
            if isinstance(key, str):
                setattr(target, key, words[name])
            else:
                target[key] = words[name]
        stick = self.stick
        neutral = stick.neutral
        stick._aim(stick._linear_permille, stick._turn_permille)
        stick.neutral = neutral
        turn = self._tick.motion._turn
        turn._plan = turn._left if turn._sign > 0 else turn._right  # no number

    def take(self, names: Sequence[str], values: Sequence[int], arcs: Sequence[int]) -> None:
        """Use these inputs from the next tick on."""
        for name, value in zip(names, values, strict=True):
            setattr(self.inputs, name, value)
        self.inputs.clearance_arcs = bytearray(arcs)

    def tick(self, around: Sequence[int], service_alive: bool) -> dict[str, int]:
        """Run one tick; returns its decisions. `around`: as trace.AROUND; without the last one, the
        wipers are where this core put them."""
        i = self.inputs
        if service_alive:
            i.service_count = (i.service_count + 1) & 0xFFFF
        elapsed_us, relay, emergency, button, verified, *neutral = around
        tick = self._tick
        tick.decide(i, elapsed_us, bool(relay), bool(emergency), bool(button))
        self.stick.write(tick.linear_permille, tick.turn_permille)
        before = tick.enable_level
        level = tick.written(bool(verified), bool((*neutral, self.stick.neutral)[0]))
        return dict(zip(trace.DECIDED, trace.decision(self._tick, level != before), strict=True))


def layouts() -> tuple[list[str], list[str]]:
    """The names of a CoreState's words, of a chair whose casters turn it further, and without."""
    settings = Settings()
    for row in range(len(PROFILES)):
        setattr(settings, profile_row(row, "caster_q4_deg"), 2 * NO_CASTERS_Q4_DEG)
    names = Core(settings, simulated=False, boot_faults=0).layout()
    return names, without_casters(names)


def without_casters(names: Sequence[str]) -> list[str]:
    """The rest of these words' names."""
    return [name for name in names if not name.startswith(_CASTERS)]
