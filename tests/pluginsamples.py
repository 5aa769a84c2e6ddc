"""Plug-ins for tests: correct ones of both kinds, and faulty ones."""

from __future__ import annotations

import contextlib
import os
import stat
import struct
import time
from dataclasses import dataclass

from gazechair.base.child_records import DATA
from gazechair.config.rules import Kind
from gazechair.plugins import (
    NOTHING,
    Input,
    Intent,
    Mode,
    World,
    choice,
    drive,
    hold,
    integer,
    setting,
    step,
)
from gazechair.plugins.exchange import Value

HOWS = ("drive", "hold", "step", "raise", "none", "hang", "die")


class Metronome(Input):
    """Presses for 0.6 s in every 1.2 s."""

    @dataclass(frozen=True)
    class Settings:
        """A metronome."""

        how: str = setting("drive", choice(*HOWS), "what it presses, or how it fails at 3 s")
        linear: int = setting(600, integer(-1000, 1000), "how far forward")

    nl = "Metronoom"
    en = "Metronome"
    _began_s = 0.0

    def sense(self, now_s: float) -> Intent:
        self._began_s = self._began_s or now_s
        how = self.settings.how
        if now_s - self._began_s > 3.0:
            if how == "raise":
                raise RuntimeError("it broke\nbadly")
            if how == "none":
                return None  # type: ignore[return-value]
            if how == "hang":
                time.sleep(60)
            if how == "die":
                os._exit(3)
        if now_s % 1.2 < 0.6:
            return NOTHING
        if how == "step":
            return step("left")
        return hold("forward") if how == "hold" else drive(self.settings.linear, 0)


class Straight(Mode):
    """Drives straight on for 3 s."""

    nl = "Rechtuit"
    en = "Straight on"

    def drive(self, world: World) -> tuple[int, int] | None:
        return (500, 0) if world.pressed_s < 3.0 else None


class Nameless(Input):
    def sense(self, now_s: float) -> Intent:
        return NOTHING


class Liar(Metronome):
    """Its clock runs ahead; it bypasses the checks in its own process."""

    def __init__(self, settings: object) -> None:
        super().__init__(settings)
        monotonic = time.monotonic
        time.monotonic = lambda: monotonic() + 5.0


class Flood(Metronome):
    """Sends as fast as it can."""

    def __init__(self, settings: object) -> None:
        super().__init__(settings)
        payload = Value(time.monotonic(), 0, NOTHING).pack()
        record = struct.pack("<I", len(payload) + 1) + DATA + payload
        fds = [fd for fd in range(3, 30) if _is_pipe(fd)]
        while True:
            for fd in fds:
                with contextlib.suppress(OSError):
                    os.write(fd, record)


def _is_pipe(fd: int) -> bool:
    try:
        return stat.S_ISFIFO(os.fstat(fd).st_mode)
    except OSError:
        return False


class Loose(Metronome):
    """Takes any setting."""

    @dataclass(frozen=True)
    class Settings(Metronome.Settings):
        """A loose table."""

        how: str = setting("drive", Kind("anything", lambda value: value), "anything")


class Tidy(Metronome):
    """Writes to its standard error that it was closed."""

    def close(self) -> None:
        os.write(2, b"closed")
