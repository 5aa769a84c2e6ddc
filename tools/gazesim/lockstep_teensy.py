"""The board in lockstep: the real main.py over a register bank, with reset and watchdog."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import gazeboard
from gazeboard.boards import bank_layout as layout
from gazeboard.boards import pins
from gazeboard.io import bootlog
from gazesim.lockstep import Clock, Files
from gazesim.lockstep_devices import QuickBoard
from gazesim.usb_line import BoardEnd, UsbLine
from gazesim.world import World

_MAIN = Path(gazeboard.__path__[0]) / "main.py"
WATCHDOG_MS = 500  # as teensy40.py sets it
BOOT_MS = 300  # a Teensy's time from reset to main.py
WATCHDOG_CAUSE = 3
SERVICES_PER_MS = 2
_ENABLE_AT = layout.PINS_AT + pins.ENABLE * layout.PIN_SIZE


class Teensy:
    """One Teensy: `app` is its firmware, None while it is off, resetting or in the REPL."""

    def __init__(self, world: World, line: UsbLine, start_us: int = 0) -> None:
        self._world = world
        self.bank = world.bank
        self.clock = Clock(start_us)
        self.files = Files()
        self.serial = BoardEnd(line)
        self.hung = False  # hangs with interrupts off
        self.watchdog = True
        self.blocked = False  # its service loop hangs, the tick continues
        self.boots = 0
        self.watchdog_bites = 0
        self._powered = True
        self._boot_in_ms = 0
        self._unfed_ms = 0
        self._feeds = 0
        self._watched = False
        self.booted: Callable[[Any], None] = lambda _app: None
        """Called with each App after the first, before it runs."""
        self.board: Any = None
        self.boot()

    @property
    def app(self) -> Any:
        """The firmware's App."""
        return None if self.board is None else self.board.app

    def boot(self) -> None:
        """Run main.py, as after any reset."""
        self.boots += 1
        boot_id = 0x0B00 + self.boots
        self.board = QuickBoard(self.bank.buffer, self.serial, self.files, boot_id, self.clock)
        with (
            mock.patch("gazeboard.boards.virtual.from_environment", return_value=self.board),
            # Send once: it would wait for an answer, but no time passes here.
            mock.patch("gazeboard.io.bootlog.last_words", bootlog.send_fault),
        ):
            runpy.run_path(str(_MAIN))
        self._watched = self.app is not None
        self._unfed_ms = 0
        if self.app is not None:
            self.booted(self.app)

    def reset(self, cause: int = 5) -> None:
        """Reset: all stops, pins float; main.py runs again BOOT_MS later."""
        self.bank.set_u32(layout.NEXT_CAUSE_AT, cause)
        self._stop()
        self._boot_in_ms = BOOT_MS

    def power_off(self) -> None:
        """Switch the power off, which the devices on its 3.3 V lose as well."""
        self._stop()
        self._powered = False
        self._world.power_off()

    def power_on(self) -> None:
        """Switch the power on: a cold start."""
        self._powered = True
        self._world.power_on()
        self.bank.power_on()
        self._boot_in_ms = BOOT_MS

    def _stop(self) -> None:
        self.board = None
        self.hung = False
        self._watched = False
        self.bank.buffer[_ENABLE_AT + layout.PIN_MODE] = 255

    def one_ms(self) -> None:
        """One millisecond of the board's life: a tick, then its service loop."""
        self.clock.now_us += 1000
        if self._boot_in_ms and self._powered:
            self._boot_in_ms -= 1
            if self._boot_in_ms == 0:
                self.boot()
        app = self.app
        if app is not None and not self.hung:
            self.board.tick(app)
            for _ in range(0 if self.blocked else SERVICES_PER_MS):
                if self.app is app:
                    self._service(app)
            self.serial.flush()
        elif self.board is not None and not self.hung:
            self.serial.flush()  # its last words, before the REPL
        self._watch()

    def _service(self, app: Any) -> None:
        try:
            app.service()
        except Exception:
            # As at the end of teensy40.run; the watchdog then resets.
            self.board.enable_pin(0)
            app.shut_down()
            self.board.app = None

    def _watch(self) -> None:
        if not (self.watchdog and self._watched):
            return
        feeds = self.bank.u32(layout.WDT_FEEDS_AT)
        self._unfed_ms = 0 if feeds != self._feeds else self._unfed_ms + 1
        self._feeds = feeds
        if self._unfed_ms >= WATCHDOG_MS:
            self.watchdog_bites += 1
            self.reset(WATCHDOG_CAUSE)
