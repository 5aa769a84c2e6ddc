# The whole firmware in virtual time with scripted devices and a small honest host. Runs on
# MicroPython too.

import struct

from gazeboard.app import App
from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazelink import arcs, codes, messages
from gazesim.lockstep import Clock, Files, LockstepBoard, Steps
from gazesim.small_host import FAR, SmallHost, clearance

_BANK_SIZE = at.SLOTS_AT + 2 * 128 * at.SLOT_SIZE
SESSION = 0x1234
BOOT = 0x0B07
POT = at.SLOTS_AT + 0x2C * at.SLOT_SIZE
IMU = at.SLOTS_AT + (128 + 0x28) * at.SLOT_SIZE
REGS = at.SLOT_REGS
NEUTRAL = 170


class Wire:
    # The serial line: bytes towards the board and from it, a ring each way.
    def __init__(self):
        self._to = bytearray(1024)
        self._head = 0
        self._tail = 0
        self.sent = bytearray(4096)
        self.count = 0
        self.reading = True  # False: the host has stopped reading, the line takes nothing more

    def read_byte(self):
        if self._tail == self._head:
            return -1
        byte = self._to[self._tail]
        self._tail = (self._tail + 1) & 1023
        return byte

    def write_some(self, buf, start, end):
        while self.reading and start < end and self.count < len(self.sent):
            self.sent[self.count] = buf[start]
            self.count += 1
            start += 1
        return start

    def push(self, data, n):
        for k in range(n):
            self._to[self._head] = data[k]
            self._head = (self._head + 1) & 1023

    def clear(self):
        self._tail = self._head


class Rig(Steps, SmallHost):
    # bank, clock, wire, app and a host that talks every 20 ms while `host_alive`.

    def __init__(self, start_us=0, files=None):
        SmallHost.__init__(self, SESSION)
        self.bank = bytearray(_BANK_SIZE)
        self.clock = Clock(start_us)
        self.wire = Wire()
        self.files = files or Files()
        self._add_devices()
        self.heading_q4 = 0.0  # counter-clockwise, as the chair stands
        self.rate_dps = 0.0
        self.imu_alive = True
        self.relay_works = True
        self._enable_edges = -1
        self._quiet_ms = 1000
        self._imu_noise = 0
        self.host_alive = True
        self.service_alive = True
        self.lidar_alive = True
        self.blocked = 0
        self.unseen = 0
        self.ways = bytearray(arcs.ALL_FAR)  # of both axes, as gazelink/arcs.py says
        self.views = 0
        self.distances = [FAR] * 4  # per direction: mm, mm, 1/16 degree, 1/16 degree
        self.bypass = 0  # number of the press that is held, 0: none
        self.watched = False  # the press is supervised in each frame
        self.source = codes.REAL
        self.command = (codes.STOP, codes.STEP, 0, codes.DRIVER, 0, 0)
        self.hold = False  # the command's time-to-live is refreshed with each frame
        self.order = None
        self._order_left = 0
        self.now_ms = 0
        self.state = {}
        self.states = 0
        self.reply = None
        self.zones = {}  # newest points per direction
        self.boot()

    def boot(self):
        self.board = LockstepBoard(self.bank, self.wire, self.files, BOOT, self.clock)
        self.app = App(self.board)
        self.keys.end()

    def _add_devices(self):
        self.bank[POT + at.SLOT_PRESENT] = 1
        self.bank[POT + at.SLOT_STYLE] = at.STYLE_AD5282
        self.bank[POT + REGS] = 0x80
        self.bank[POT + REGS + 1] = 0x80
        self.bank[IMU + at.SLOT_PRESENT] = 1
        self.bank[IMU + REGS] = 0xA0
        self.drive_pin(pins.EMERGENCY, 0)

    def drive_pin(self, number, level):
        offset = at.PINS_AT + number * at.PIN_SIZE
        self.bank[offset + at.PIN_HOST_DRIVE] = 1
        self.bank[offset + at.PIN_HOST_LEVEL] = level

    # -- running ---------------------------------------------------------------------------------

    def one_ms(self):
        self.world_ms()
        self.board.tick(self.app)
        if self.service_alive:
            self.app.service()
            self.app.service()
        self.listen()

    # What happens around the board before its tick.
    def world_ms(self):
        self.now_ms += 1
        self.clock.now_us += 1000
        self._relay()
        if self.now_ms % 10 == 0 and self.imu_alive:
            self._sense()
        if self.host_alive and self.now_ms % 20 == 0:
            self.speak()

    # The relay: closed while the enable line toggles, open 15 ms after it stopped.
    def _relay(self):
        edges = self.bank[at.PINS_AT + pins.ENABLE * at.PIN_SIZE + at.PIN_OUT_COUNT]
        level = self.bank[at.PINS_AT + pins.ENABLE * at.PIN_SIZE + at.PIN_OUT]
        toggled = edges != self._enable_edges and level != getattr(self, "_level", 0)
        self._enable_edges = edges
        self._level = level
        self._quiet_ms = 0 if toggled else self._quiet_ms + 1
        self.relay_closed = self._quiet_ms < 15 and self.relay_works
        self.drive_pin(pins.RELAY_FEEDBACK, 1 if self.relay_closed else 0)

    def _sense(self):
        self.heading_q4 += self.rate_dps * 16 / 100
        self._imu_noise = (self._imu_noise * 5 + 3) & 7
        raw = int(-self.heading_q4) % 5760
        struct.pack_into(
            "<4h",
            self.bank,
            IMU + REGS + 0x14,
            self._imu_noise,
            -self._imu_noise,
            int(self.rate_dps * 16),
            raw,
        )

    # -- the host ----------------------------------------------------------------------------------

    def speak(self):
        if not self.keys.live:
            self.say_hello()
            return
        verb, mode, edge, owner, linear, turn = self.command
        ttl = 300 if self.hold else 0
        if self.watched:
            self.send(messages.SUPERVISION, (edge, owner, 0))
        self.send(messages.COMMAND, (verb, mode, edge, owner, ttl, linear, turn, 1000, 0))
        if self.lidar_alive:
            self.see()
        if self.bypass:
            self.send(messages.BYPASS, (self.bypass, 300))
        if self._order_left:
            self._order_left -= 1
            self.send(messages.ORDER, self.order)

    def see(self):
        values = clearance(
            self.blocked, self.source, 5, self.distances, self.unseen, self.ways, self.views
        )
        self.send(messages.CLEARANCE, values)

    def put(self, buf, n):
        self.wire.push(buf, n)

    def give(self, action, owner=codes.DRIVER):
        self.order = self.next_order(action, owner)
        self._order_left = 5

    def listen(self):
        self.hear(self.wire.sent, self.wire.count)
        self.wire.count = 0

    def received(self, kind, buf):
        if kind == messages.STATE.type_id:
            self.state = messages.STATE.unpack(buf)
            self.states += 1
        elif kind == messages.SETTING_REPLY.type_id:
            self.reply = messages.SETTING_REPLY.unpack(buf)
        elif kind == messages.ZONE.type_id:
            told = messages.ZONE.unpack(buf)
            self.zones[told["direction"]] = told["points"]

    # -- what tests ask ----------------------------------------------------------------------------

    def wipers(self):
        return (self.bank[POT + REGS], self.bank[POT + REGS + 1])

    def neutral(self):
        return self.wipers() == (NEUTRAL, NEUTRAL)

    def arm(self):
        self.run(1200)
        self.give(codes.ARM)
        self.run(300)
        assert self.app.safety.state == codes.ARMED, self.why()

    def press(self, verb, mode=codes.CONTINUOUS, linear=0, turn=0):
        edge = self.command[2] % 255 + 1
        self.command = (verb, mode, edge, codes.DRIVER, linear, turn)
        self.hold = True

    # A press that nobody holds, supervised from now on.
    def auto(self, linear=500, turn=0):
        self.press(codes.DRIVE, codes.AUTO, linear, turn)
        self.watched = True

    def release(self):
        self.command = (codes.STOP, 0, self.command[2], codes.DRIVER, 0, 0)
        self.hold = False

    def drive(self, verb=codes.FORWARD):
        self.arm()
        self.press(verb)
        self.run(60)
        assert not self.neutral(), self.why()

    def why(self):
        s = self.app.safety
        return "state %d faults %x override %s arm_reason %s wipers %s" % (
            s.state,
            s.faults,
            codes.reason_name(s.override),
            codes.reason_name(s.arm_reason),
            self.wipers(),
        )
