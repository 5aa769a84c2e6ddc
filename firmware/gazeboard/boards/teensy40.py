# The Teensy 4.0 (MicroPython mimxrt): the only file that uses `machine`.
#
# Facts are in docs/wiring.md. The tick is a hard timer interrupt on its own I2C bus; the service
# loop is the main program.

import gc
import os
import time

import machine
import micropython

from gazeboard.boards import pins
from gazeboard.boards.stdio import StdioSerial
from gazeboard.io.storage import Files

_WATCHDOG_MS = 500
_MAINTENANCE_WATCHDOG_MS = 128000
_FLASH_WATCHDOG_MS = 8000
_BASE = "/flash"

micropython.alloc_emergency_exception_buf(100)


class Teensy40:
    name = "teensy40"

    def __init__(self):
        uname = os.uname()
        self.simulated = "QEMU" in uname.machine
        self.enable_pin = machine.Pin("D%d" % pins.ENABLE, machine.Pin.OUT, value=0)
        self.led_pin = machine.Pin("D%d" % pins.LED, machine.Pin.OUT, value=0)
        self.relay_pin = self._input(pins.RELAY_FEEDBACK)
        self.emergency_pin = self._input(pins.EMERGENCY)
        self.button_pin = self._input(pins.BUTTON)
        self.joystick_i2c = machine.I2C(
            pins.JOYSTICK_BUS, freq=pins.I2C_HZ, timeout=pins.JOYSTICK_TIMEOUT_US
        )
        self.imu_i2c = machine.I2C(pins.IMU_BUS, freq=pins.I2C_HZ, timeout=pins.IMU_TIMEOUT_US)
        self.serial = StdioSerial()
        self.reset_cause = machine.reset_cause()
        self.boot_id = int.from_bytes(os.urandom(2), "little") or 1
        self.ticks_us = time.ticks_us
        self.ticks_ms = time.ticks_ms
        self.ticks_diff = time.ticks_diff
        self._files = Files(_BASE)
        self._watchdog = None
        self._timer = None
        self.hard_timer = self._has_hard_timer()

    # The i.MX RT's true random number generator.
    def draw_nonce(self, nonce):
        nonce[0:4] = os.urandom(4)

    def _input(self, number):
        return machine.Pin("D%d" % number, machine.Pin.IN, machine.Pin.PULL_UP)

    # Older firmware takes `hard` for a soft timer's unknown argument, or refuses it: try, don't
    # guess.
    def _has_hard_timer(self):
        try:
            timer = machine.Timer(-1, period=1000, callback=_nothing, hard=True)
        except (TypeError, ValueError):
            return False
        timer.deinit()
        return True

    def feed_watchdog(self):
        if self._watchdog is not None:
            self._watchdog.feed()

    def heap_free_kb(self):
        return gc.mem_free() >> 10

    def load(self, name):
        return self._files.load(name)

    # A flash erase stops the processor for up to 400 ms: only while disarmed, with a patient
    # watchdog, which is strict again whatever came of it.
    def store(self, name, text):
        self._patience(_FLASH_WATCHDOG_MS)
        try:
            self._files.store(name, text)
        finally:
            self._patience(_WATCHDOG_MS)

    def remove(self, name):
        self._patience(_FLASH_WATCHDOG_MS)
        try:
            self._files.remove(name)
        finally:
            self._patience(_WATCHDOG_MS)

    def _patience(self, timeout_ms):
        if self._watchdog is not None:
            self._watchdog.feed()
            self._watchdog.timeout_ms(timeout_ms)
            self._watchdog.feed()

    def run(self, app):
        micropython.kbd_intr(
            -1
        )  # byte 3 is data; a Ctrl-C inside an I2C transfer would stop the tick
        if self.hard_timer:
            self._timer = machine.Timer(-1, period=1, callback=app.tick, hard=True)
        self._watchdog = machine.WDT(timeout=_WATCHDOG_MS)
        try:
            while app.service():
                pass
            self._patience(_MAINTENANCE_WATCHDOG_MS)  # requested: time to work in the REPL
        finally:
            # After an exception the watchdog is left to bite: a reset, then neutral (P1, P10).
            self.enable_pin(0)
            if self._timer is not None:
                self._timer.deinit()
            app.shut_down()
            self.open_repl()

    # Ctrl-C works again: for mpremote, and for people.
    def open_repl(self):
        micropython.kbd_intr(3)


def _nothing(_timer):
    pass
