# The virtual board: runs the firmware over a register bank, without hardware.
#
# As a process (MicroPython or CPython on Linux) the environment names the bank file and a folder
# for small files; stdin and stdout are the serial line. In lockstep a test passes bank, serial
# and clock.

import os
import sys

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.boards.bank_devices import BankI2C, BankPin, count_up, put_u32, u32
from gazeboard.core.limits import WIPER_NEUTRAL
from gazeboard.io.joystick import ADDRESS
from gazeboard.io.storage import Files

_TICK_US = 1000
_CATCH_UP_US = 5000  # a PC that stalled longer paused the board
_LEAD_MS = 10  # the board waits for a simulated world that is further behind than this
_TICKS_MASK = 0x3FFFFFFF
_HANG = 2  # host flag: the simulator stops this process on purpose


class VirtualBoard:
    name = "virtual"
    simulated = True
    hard_timer = True  # the deadline loop below never lets service and tick overlap

    def __init__(self, bank, serial, files, boot_id, ticks_us, ticks_diff):
        self.joystick_i2c = BankI2C(bank, pins.JOYSTICK_BUS)
        self.enable_pin = BankPin(bank, pins.ENABLE, True)
        self._neutral_first()
        self.imu_i2c = BankI2C(bank, pins.IMU_BUS)
        self.led_pin = BankPin(bank, pins.LED, True)
        self.relay_pin = BankPin(bank, pins.RELAY_FEEDBACK, False)
        self.emergency_pin = BankPin(bank, pins.EMERGENCY, False)
        self.button_pin = BankPin(bank, pins.BUTTON, False)
        self._bank = bank
        self.serial = serial
        self._files = files
        self.boot_id = boot_id
        self._clock_us = ticks_us
        self.ticks_diff = ticks_diff
        self._lost_us = 0
        self._ticked_us = 0  # when the last tick began
        self._begins_us = -1  # the coming reading, which is a tick's first; below 0: read the clock
        self._ms = 0
        self._ms_at_us = self.ticks_us()
        self._lead_ms = 0
        self._world_ms = 0
        cause = u32(bank, at.NEXT_CAUSE_AT)
        self.reset_cause = cause if cause else 1
        put_u32(bank, at.RESET_CAUSE_AT, self.reset_cause)
        put_u32(bank, at.NEXT_CAUSE_AT, 0)
        put_u32(bank, at.TICK_MS_AT, 0)
        count_up(bank, at.BOOT_COUNT_AT)

    # The PC's random numbers.
    def draw_nonce(self, nonce):
        nonce[0:4] = os.urandom(4)

    # Promise P1: before anything else. A pot that does not answer leaves the enable line off.
    def _neutral_first(self):
        self.enable_pin(0)
        try:
            self.joystick_i2c.writeto(ADDRESS, bytes((0x00, WIPER_NEUTRAL)))
            self.joystick_i2c.writeto(ADDRESS, bytes((0x80, WIPER_NEUTRAL)))
        except OSError:
            pass

    # The board's time: the PC's, less the PC's stalls. A real timer would have continued to tick;
    # a PC that suspends the process is not firmware that hangs.
    def ticks_us(self):
        begins_us = self._begins_us
        if begins_us >= 0:
            self._begins_us = -1
            return begins_us
        return (self._clock_us() - self._lost_us) & _TICKS_MASK

    # Milliseconds counted from those, because their own wrap is not at a whole number of them.
    def ticks_ms(self):
        whole = self.ticks_diff(self.ticks_us(), self._ms_at_us) // 1000
        if whole > 0:
            self._ms = (self._ms + whole) & _TICKS_MASK
            self._ms_at_us = (self._ms_at_us + whole * 1000) & _TICKS_MASK
        return self._ms

    def feed_watchdog(self):
        count_up(self._bank, at.WDT_FEEDS_AT)

    def heap_free_kb(self):
        return 0  # the PC's memory does not show the board's

    def load(self, name):
        return self._files.load(name)

    def store(self, name, text):
        self._files.store(name, text)

    def remove(self, name):
        self._files.remove(name)

    def open_repl(self):
        pass  # the process ends instead

    # One tick as the timer would: the tick's own clock goes into the bank, for the simulator.
    def tick(self, app):
        app.tick()
        count_up(self._bank, at.TICK_MS_AT)

    # A deadline loop. One thread: a tick never interrupts a service slice, it waits for its end.
    def run(self, app):
        due_us = self.ticks_us()
        self._ticked_us = (due_us - _TICK_US) & _TICKS_MASK
        running = True
        while running:  # an exception ends the process: the simulator starts it again, as a reset
            now_us = self.ticks_us()
            behind_us = self.ticks_diff(now_us, due_us)
            waiting = self._ahead_of_world()
            if behind_us > _CATCH_UP_US or (waiting and behind_us > 0):
                if self._hung():
                    due_us = now_us
                else:
                    due_us = self._lose(due_us, now_us)
                    if self.ticks_diff(now_us, due_us) > 0:
                        now_us = due_us
                behind_us = self.ticks_diff(now_us, due_us)
            if behind_us >= 0 and not waiting:
                due_us = (due_us + _TICK_US) & _TICKS_MASK
                # The tick begins at this reading: a stall from here on is lost in the next pass.
                self._ticked_us = self._begins_us = now_us
                self.tick(app)
                self._lead_ms += 1
            running = app.service()
            left_us = self.ticks_diff(due_us, self.ticks_us())
            if left_us > 50:
                sleep_us(min(left_us, _TICK_US))
        app.shut_down()

    # The PC's stall did not happen: the time is again when a tick was due, but a period after the
    # last one at least. A tick that began before it would count as a long stall.
    def _lose(self, due_us, now_us):
        earliest_us = (self._ticked_us + _TICK_US) & _TICKS_MASK
        if self.ticks_diff(earliest_us, due_us) > 0:
            due_us = earliest_us
        lost_us = self.ticks_diff(now_us, due_us)
        if lost_us > 0:
            self._lost_us = (self._lost_us + lost_us) & _TICKS_MASK
            if self.ticks_diff(due_us, self._ms_at_us) < 0:
                # A slice has counted the stall: its milliseconds go on from here, not after it.
                self._ms_at_us = due_us
        return due_us

    # Was the time just lost a hang, which the firmware must find late, and not a stall of the PC?
    def _hung(self):
        if not u32(self._bank, at.HOST_FLAGS_AT) & _HANG:
            return False
        put_u32(self._bank, at.HOST_FLAGS_AT, 0)
        return True

    # Is the simulated world, a process of its own, stalled? Then its sensors stand still for no
    # fault of theirs: the board's time waits for it. A world that is ahead is not caught up with.
    def _ahead_of_world(self):
        world_ms = u32(self._bank, at.WORLD_MS_AT)
        passed_ms = world_ms - self._world_ms
        self._lead_ms = max(-_LEAD_MS, self._lead_ms - passed_ms) if passed_ms >= 0 else 0
        self._world_ms = world_ms
        return world_ms != 0 and self._lead_ms > _LEAD_MS


if sys.implementation.name == "micropython":
    from time import sleep_us, ticks_diff, ticks_us
else:
    from gazeboard.boards.unix_cpython import sleep_us, ticks_diff, ticks_us


def from_environment():
    # The process's board; raises ValueError with the reason when the environment is not usable.
    # Only a process needs these: a MicroPython without ffi runs the lockstep.
    if sys.implementation.name == "micropython":
        from gazeboard.boards.stdio import StdioSerial
        from gazeboard.boards.unix_micropython import getenv, map_file
    else:
        from gazeboard.boards.unix_cpython import StdioSerial, getenv, map_file
    path = getenv("GAZEBOARD_BANK")
    folder = getenv("GAZEBOARD_STATE")
    if not path or not folder:
        raise ValueError("GAZEBOARD_BANK (bank file) and GAZEBOARD_STATE (folder) must be set")
    bank = map_file(path, at.SIZE)
    if u32(bank, at.MAGIC_AT) != at.MAGIC or u32(bank, at.VERSION_AT) != at.VERSION:
        raise ValueError("%s is not a register bank of version %d" % (path, at.VERSION))
    boot_id = int.from_bytes(os.urandom(2), "little") or 1
    return VirtualBoard(bank, StdioSerial(), Files(folder), boot_id, ticks_us, ticks_diff)
