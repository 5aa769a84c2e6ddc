"""The world in lockstep with the whole firmware, in virtual time: driving, collisions, faults."""

import pytest

from gazeboard.app import App
from gazeboard.boards.virtual import VirtualBoard
from gazelink import codes, frame, messages
from gazesim.bank import Bank
from gazesim.small_host import clearance
from gazesim.world import World


class Wire:
    """The serial line inside one process."""

    def __init__(self):
        self.to_board = bytearray()
        self.to_host = bytearray()

    def read_byte(self):
        return self.to_board.pop(0) if self.to_board else -1

    def write_some(self, buf, start, end):
        self.to_host += buf[start:end]
        return end


class Files:
    """The board's files, in memory."""

    def load(self, name):
        return None

    def store(self, name, text):
        pass

    def remove(self, name):
        pass


class Lockstep:
    """World, firmware and a small host, all moved on by `run`."""

    def __init__(self, room="open", profile="3.1", seed=1):
        self.bank = Bank.in_memory()
        self.world = World(self.bank, room, profile, seed)
        self.wire = Wire()
        self.now_us = 0
        self.board = VirtualBoard(
            self.bank.buffer, self.wire, Files(), 7, lambda: self.now_us, lambda a, b: a - b
        )
        self.app = App(self.board)
        self.encoder, self.decoder = frame.Encoder(), frame.Decoder()
        self.encoder.session = self.decoder.session = self.keys = frame.Session()
        self.ticking = True
        self.command = (codes.STOP, codes.STEP, 0)
        self.order = 0
        self.stamp = 0
        self.trace = []

    def run(self, ms):
        for _ in range(ms):
            self.now_us += 1000
            if self.now_us % 20000 == 0:
                self.speak()
            if self.ticking:
                self.board.tick(self.app)
                self.app.service()
                self.app.service()
            self.listen()
            self.world.step(0.001)
            self.trace.append((*self.world.pose, *self.world.wipers, self.world.relay.closed))

    def speak(self):
        if not self.keys.live:
            self.send(messages.HELLO, (0, 0, frame.schema_hash(), 99, 0, 0, 1, 0, b"test"))
            return
        verb, mode, edge = self.command
        ttl_ms = 300 if verb else 0
        self.send(messages.COMMAND, (verb, mode, edge, codes.DRIVER, ttl_ms, 0, 0, 1000, 0))
        self.send(messages.CLEARANCE, clearance(0, codes.SIMULATED, 5))
        if self.order:
            self.send(messages.ORDER, (codes.ARM, self.order, codes.DRIVER))

    def send(self, message, values):
        message.pack(self.encoder.body, values)
        count = self.encoder.finish(message, self.stamp)
        self.wire.to_board += self.encoder.wire[:count]

    def listen(self):
        for byte in self.wire.to_host:
            if not self.decoder.feed(byte):
                continue
            heard = self.decoder.buf
            self.stamp = frame.u16(heard, messages.STAMP_AT)
            if heard[0] == messages.HELLO.type_id:
                boot = messages.HELLO.unpack(heard)["boot"]
            elif heard[0] == messages.NONCE.type_id and not self.keys.live:
                begun = messages.NONCE.unpack(heard)
                self.keys.begin(99, boot, begun["nonce"], begun["epoch"], self.stamp)
            self.keys.advance(self.stamp)
        self.wire.to_host.clear()

    def arm(self):
        self.run(1500)
        self.order = 1
        self.run(600)
        assert self.app.safety.state == codes.ARMED, self.app.safety.arm_reason

    def press(self, verb, mode=codes.CONTINUOUS):
        self.command = (verb, mode, self.command[2] + 1)

    def release(self):
        self.command = (codes.STOP, codes.STEP, self.command[2])


def test_the_firmware_arms_through_the_simulated_relay_and_drives():
    lock = Lockstep()
    assert not lock.world.relay.closed
    lock.arm()
    truth = lock.world.truth()
    assert truth["relay_closed"]
    assert truth["joystick"] == "ok"
    lock.press(codes.FORWARD)
    lock.run(1000)
    assert lock.world.truth()["x_m"] > 0.05
    lock.release()
    lock.run(1500)
    assert lock.world.wipers == (170, 170)
    assert lock.world.truth()["speed_m_s"] == 0.0


def test_left_turns_counter_clockwise():
    lock = Lockstep()
    lock.arm()
    lock.press(codes.LEFT)
    lock.run(1000)
    assert lock.world.truth()["heading_deg"] > 5.0


def test_a_hanging_board_stops_the_chair_by_the_relay():
    lock = Lockstep()
    lock.arm()
    lock.press(codes.FORWARD)
    lock.run(1500)
    lock.ticking = False
    lock.run(20)
    assert not lock.world.relay.closed
    assert lock.world.wipers != (170, 170)  # the pot holds its last value
    lock.run(2000)
    assert lock.world.truth()["speed_m_s"] == 0.0


def test_equal_seeds_give_equal_traces():
    traces = []
    for seed in (3, 3, 4):
        lock = Lockstep("living", seed=seed)
        lock.arm()
        lock.press(codes.LEFT)
        lock.run(800)
        lock.press(codes.FORWARD)
        lock.run(800)
        traces.append(lock.trace)
    assert traces[0] == traces[1]
    assert traces[0] != traces[2]


@pytest.mark.parametrize(
    ("fault", "bit"),
    [
        ("imu_nak", codes.HEADING_BUS),
        ("imu_bus_stuck", codes.HEADING_BUS),
        ("imu_freeze", codes.HEADING_FROZEN),
        ("imu_self_reset", codes.HEADING_RESET),
        ("wiper_nak", codes.WIPER),
        ("wiper_stuck", codes.WIPER),
        ("wiper_bus_stuck", codes.WIPER),
        ("emergency", codes.EMERGENCY),
        ("relay_stuck_open", codes.RELAY_OPEN),
        ("tilt", codes.TILT),
    ],
)
def test_the_firmware_sees_the_fault_that_was_injected(fault, bit):
    lock = Lockstep()
    lock.arm()
    lock.press(codes.FORWARD if bit in (codes.WIPER, codes.EMERGENCY) else codes.LEFT)
    lock.run(400)
    lock.world.faults.inject(fault)
    seen = 0
    for _ in range(40):
        lock.run(10)
        seen |= lock.app.safety.faults
    assert seen >> bit & 1, f"{seen:#x}"


def drive(world, seconds):
    """Full deflection forward with the relay held closed, no board."""
    world.faults.inject("relay_stuck_closed")
    slot = world.bank.slot(0, 0x2C)
    slot.write(0, bytes((170, 170)))
    world.step(0.001)
    slot.write(0, bytes((254, 170)))
    for _ in range(round(seconds * 1000)):
        world.step(0.001)


def test_a_wall_stops_the_chair_and_the_bump_is_counted():
    world = World(Bank.in_memory(), "wall", "5.1")
    drive(world, 12.0)
    truth = world.truth()
    assert truth["collided"]
    assert truth["collisions"] == 1
    assert truth["x_m"] == pytest.approx(4.0 - 0.65, abs=0.03)
    assert truth["clearance_m"] < 0.03


def test_an_obstacle_stands_where_it_was_put_until_cleared():
    world = World(Bank.in_memory(), "open")
    world.faults.inject("obstacle", ahead_m=1.5)
    assert world.truth()["clearance_m"] == pytest.approx(1.5 - 0.65, abs=0.01)
    assert world.truth()["faults"] == ["obstacle"]
    world.faults.clear("obstacle")
    assert world.truth()["clearance_m"] > 5.0


def test_a_chair_is_not_put_into_a_wall():
    world = World(Bank.in_memory(), "wall")
    with pytest.raises(ValueError, match="does not fit at x"):
        world.teleport(3.9, 0.0, 0.0)
    with pytest.raises(ValueError, match="finite"):
        world.teleport(float("nan"), 0.0, 0.0)
    world.teleport(1.0, 0.5, 90.0)
    assert world.pose == (1.0, 0.5, 90.0)


def test_the_lidar_sees_the_room_from_its_place_on_the_chair():
    world = World(Bank.in_memory(), "wall")
    world.lidar.receive(b"\xa5\x20")
    data = b"".join(world.step(0.001) for _ in range(200))[7:]
    angle_mm = [
        ((data[k + 1] | data[k + 2] << 8) >> 1, (data[k + 3] | data[k + 4] << 8) / 4)
        for k in range(0, len(data) - 4, 5)
    ]
    ahead = sorted(mm for angle, mm in angle_mm if mm and (angle < 64 or angle > 359 * 64))
    assert ahead[len(ahead) // 2] == pytest.approx(3500, abs=15)  # 4 m less the lidar's 0.5 m


def test_every_fault_of_the_world_can_be_injected_and_cleared():
    world = World(Bank.in_memory(), "living")
    for name in world.faults.names():
        world.faults.inject(name)
        world.step(0.001)
        world.faults.clear(name)
    assert world.faults.active() == []
    assert set(world.faults.meanings()) == set(world.faults.names())


@pytest.mark.parametrize(
    ("name", "arguments", "reason"),
    [
        ("flood", {}, "no fault 'flood'; there are"),
        ("imu_jump", {"angle": 3.0}, "imu_jump has no argument 'angle'; it takes jump_deg"),
        ("imu_jump", {"jump_deg": "far"}, "jump_deg is not a number"),
        ("imu_jump", {"jump_deg": float("nan")}, "jump_deg is not within"),
        ("lidar_drop", {"share": 2.0}, "is not within"),
        ("door_closed", {"door": "attic"}, "no door 'attic'"),
    ],
)
def test_a_bad_fault_is_refused_with_the_reason_and_is_not_active(name, arguments, reason):
    world = World(Bank.in_memory(), "living")
    with pytest.raises(ValueError, match=reason):
        world.faults.inject(name, **arguments)
    assert world.faults.active() == []
