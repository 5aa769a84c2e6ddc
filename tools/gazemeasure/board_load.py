# Load program for the emulated Teensy: the whole firmware at its worst load.
#
# Time is a count of instructions. A host inside the board sends every 20 ms, drives through every
# motion, override and fault; the sensor answers with stretched clocks; telemetry streams; garbage
# is made and collected.
#
# Prints one line of results. RUN_MS, STATE_PERIOD_MS, STRETCH_US and PARTS, [(attribute of App,
# method, number of its arguments)] to be counted singly, are put before this text.
# ruff: noqa: F821

import array
import gc
import time

import machine
from gazeboard.app import App
from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.boards.teensy40 import Teensy40
from gazelink import arcs, codes, frame, messages

BANK = 0x60000000
IMU = BANK + at.SLOTS_AT + (128 + 0x28) * at.SLOT_SIZE
POT = BANK + at.SLOTS_AT + 0x2C * at.SLOT_SIZE
mem8 = machine.mem8
mem32 = machine.mem32


def pin(number, level):
    where = BANK + at.PINS_AT + number * at.PIN_SIZE
    mem8[where + at.PIN_HOST_DRIVE] = 1
    mem8[where + at.PIN_HOST_LEVEL] = level


def prepare():
    mem8[POT + at.SLOT_STYLE] = at.STYLE_AD5282
    mem8[POT + at.SLOT_PRESENT] = 1
    mem8[IMU + at.SLOT_REGS] = 0xA0
    mem32[IMU + at.SLOT_STRETCH_US] = STRETCH_US
    mem8[IMU + at.SLOT_PRESENT] = 1
    pin(pins.EMERGENCY, 0)
    pin(pins.RELAY_FEEDBACK, 0)


class HostInside:
    # The board's serial line: frames of a scripted host come in, telemetry goes to the real line.

    def __init__(self, line):
        self._line = line
        self.encoder = frame.Encoder()
        self._frame = bytearray(64)
        self._n = 0
        self._at = 0
        self.waiting_since_us = 0
        self.latency_us = array.array("H", [0] * 64)  # histogram of 250 us
        self.latency_max_us = 0

    def give(self, message):
        n = self.encoder.finish(message, app.outbox.ticks & 0xFFFF)
        wire = self.encoder.wire
        for k in range(n):
            self._frame[k] = wire[k]
        self._at = 0
        self._n = n
        self.waiting_since_us = time.ticks_us()

    def busy(self):
        return self._at < self._n

    def read_byte(self):
        if self._at >= self._n:
            return -1
        byte = self._frame[self._at]
        self._at += 1
        return byte

    def write_some(self, buf, start, end):
        return self._line.write_some(buf, start, end)

    def decoded(self):
        took = time.ticks_diff(time.ticks_us(), self.waiting_since_us)
        self.latency_max_us = max(self.latency_max_us, took)
        slot = min(63, took // 250)
        self.latency_us[slot] += 1


prepare()
board = Teensy40()
board.simulated = True
host = HostInside(board.serial)
board.serial = host
app = App(board)
RUN_TICKS = RUN_MS
parts = None
if PARTS:
    from board_parts import Parts

    parts = Parts(len(PARTS))
    for name, method, words in PARTS:
        parts.watch(getattr(app, name), method, words, name + "." + method)

# Written by the tick's wrapper: no allocation, because the timer is hard.
phase = array.array("I", [0] * 128)  # tick start, us after the grid, histogram
gaps = array.array("I", [0, 0, 0])  # ticks, missed, grid offset
worst = array.array("I", [0] * 4)  # us: worst tick, sum of ticks (two words), ticks measured
last_us = array.array("I", [0])


def tick(timer):
    start = time.ticks_us()
    if gaps[0]:
        step = time.ticks_diff(start, last_us[0])
        if step > 1500:
            gaps[1] += step // 1000 - 1
    else:
        gaps[2] = start % 1000
    late = (start - gaps[2]) % 1000
    if late >= 500:
        late = 1000 - late  # the first tick itself was late
    if late > 127:
        late = 127
    phase[late] += 1
    last_us[0] = start
    gaps[0] += 1
    # Counting the above is not part of the tick.
    start = time.ticks_us()
    start_cpu = time.ticks_cpu()
    app.tick(timer)
    took = time.ticks_diff(time.ticks_us(), start)
    if parts:
        parts.tick(time.ticks_diff(time.ticks_cpu(), start_cpu))
    if took > worst[0]:
        worst[0] = took
        worst[3] = app.outbox.ticks
    worst[1] += took


class Measured:
    # The app for board.run().

    def tick(self, timer):
        tick(timer)

    def __init__(self):
        self._noise = 0
        self._spoken_at = -100
        self._sensed_at = -100
        self._edge = 0
        self._number = 0
        self._junk = []
        self.reached = 0  # bit set of override codes seen
        self.moved = 0

    def service(self):
        ticks = app.outbox.ticks
        app_running = ticks < RUN_TICKS
        # The simulated hardware: contact follows the enable line, the sensor's bytes never stand
        # still.
        pin(pins.RELAY_FEEDBACK, 1 if app.safety.enable else 0)
        if ticks - self._sensed_at >= 10:
            self._sensed_at = ticks
            self._noise = (self._noise + 1) & 3
            if ticks // 3000 % 5 != 4:  # in one phase of five the sensor is frozen
                mem8[IMU + at.SLOT_REGS + 0x14] = self._noise
                mem8[IMU + at.SLOT_REGS + 0x16] = 3 - self._noise
        if not host.busy() and ticks - self._spoken_at >= 5:
            self._spoken_at = ticks
            self._speak(ticks)
        before = app.link._decoder.ok
        going = app.service()
        if app.link._decoder.ok != before:
            host.decoded()
        self._junk = [ticks] * 20  # garbage, as real service code makes
        self.reached |= 1 << app.safety.override if app.safety.override < 28 else 0
        if app.motion.state:
            self.moved += 1
        return going and app_running

    # The second half of each drive is an auto motion, supervised since before it.
    def _auto(self, ticks, since):
        return ticks // 1000 % 5 == 4 and ticks % 1000 >= since

    def _speak(self, ticks):
        # A round: hello, then in turn command, clearance, order, ping.
        if app.link._session == 0:
            messages.HELLO.pack(
                host.encoder.body, (0, 0, frame.schema_hash(), 77, 0, 0, 1, 0, b"load")
            )
            host.give(messages.HELLO)
            return
        host.encoder.session = app.link._keys  # the nonce is inside, too
        turn = ticks // 5 % 4
        second = ticks // 1000
        if turn == 0:
            verb = (codes.FORWARD, codes.LEFT, codes.RIGHT, codes.BACKWARD, codes.DRIVE)[second % 5]
            if ticks % 1000 < 200 or second < 2:
                verb = codes.STOP
            mode = second // 5 % 2
            edge = second % 127 + 1
            if self._auto(ticks, 600):
                mode = codes.AUTO
                edge += 127
            messages.COMMAND.pack(
                host.encoder.body, (verb, mode, edge, codes.DRIVER, 300, 400, -300, 1000, 0)
            )
            host.give(messages.COMMAND)
        elif turn == 1:
            blocked = 15 if second % 7 == 6 else 0
            # In turn: nothing within range, a finite distance, and a near one.
            ahead = (messages.CLEAR_FAR, 900, 600)[second % 3]
            messages.CLEARANCE.pack(
                host.encoder.body,
                (blocked, second & 4, codes.SIMULATED, ahead, ahead, ahead, ahead, 10, 0)
                + (bytes([min(arcs.FAR, ahead // arcs.UNIT_MM)] * arcs.SIZE),),
            )
            host.give(messages.CLEARANCE)
        elif turn == 2 and self._auto(ticks, 560):
            messages.SUPERVISION.pack(host.encoder.body, (second % 127 + 128, codes.DRIVER, 0))
            host.give(messages.SUPERVISION)
        elif turn == 2:
            if app.safety.state == codes.DISARMED:
                self._number = self._number % 255 + 1
            messages.ORDER.pack(host.encoder.body, (codes.ARM, self._number, codes.DRIVER))
            host.give(messages.ORDER)
        elif app.telemetry.period_ms != STATE_PERIOD_MS:
            messages.TELEMETRY.pack(host.encoder.body, (STATE_PERIOD_MS,))
            host.give(messages.TELEMETRY)
        elif TRACED and not app.trace.on:
            messages.TRACE_REQUEST.pack(host.encoder.body, (1,))
            host.give(messages.TRACE_REQUEST)
        else:
            messages.PING.pack(host.encoder.body, (ticks & 0xFFFF, 0))
            host.give(messages.PING)

    def shut_down(self):
        app.shut_down()


measured = Measured()
gc.collect()
board.run(measured)
for _ in range(200):
    app.link.poll(app)  # what was captured before the end
time.sleep_ms(50)
print()
print(
    "RESULT",
    {
        "ticks": gaps[0],
        "missed": gaps[1],
        "worst_us": worst[0],
        "worst_at": worst[3],
        "sum_us": worst[1],
        "phase": list(phase),
        "latency": list(host.latency_us),
        "latency_max_us": host.latency_max_us,
        "corrupt": app.link._decoder.corrupt,
        "stale": app.link.incoming.stale,
        "bad": app.link.incoming.bad,
        "tx_dropped": app.telemetry.dropped,
        "imu_samples": app._imu.samples,
        "imu_errors": app._imu.errors,
        "service_max_ms": app.service_max_ms,
        "heap_free": gc.mem_free(),
        "reached": measured.reached,
        "moved": measured.moved,
        "parts": parts.found() if parts else (),
        "state": app.safety.state,
        "faults": app.safety.faults,
    },
)
