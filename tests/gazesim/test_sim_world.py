"""The world in lockstep with the whole firmware, in virtual time: driving, collisions, faults."""

import struct

import pytest

from gazeboard.boards.bank_devices import BankI2C
from gazelink import codes
from gazesim.bank import Bank
from gazesim.chair_rig import LinkedChair
from gazesim.lockstep_teensy import BOOT_MS
from gazesim.rooms import Person
from gazesim.world import World


def test_the_firmware_arms_through_the_simulated_relay_and_drives():
    chair = LinkedChair()
    assert not chair.world.relay.closed
    chair.arm()
    truth = chair.world.truth()
    assert truth["relay_closed"]
    assert truth["joystick"] == "ok"
    chair.press(codes.FORWARD)
    chair.run(1000)
    assert chair.world.truth()["x_m"] > 0.05
    chair.release()
    chair.run(1500)
    assert chair.world.wipers == (170, 170)
    assert chair.world.truth()["speed_m_s"] == 0.0


def test_left_turns_counter_clockwise():
    chair = LinkedChair()
    chair.arm()
    chair.press(codes.LEFT)
    chair.run(1000)
    assert chair.world.truth()["heading_deg"] > 5.0


def test_a_hanging_board_stops_the_chair_by_the_relay():
    chair = LinkedChair()
    chair.arm()
    chair.press(codes.FORWARD)
    chair.run(1500)
    chair.board.watchdog = False
    chair.board.hung = True
    chair.run(20)
    assert not chair.world.relay.closed
    assert chair.world.wipers != (170, 170)  # the pot holds its last value
    chair.run(2000)
    assert chair.world.truth()["speed_m_s"] == 0.0


def test_equal_seeds_give_equal_traces():
    traces = []
    for seed in (3, 3, 4):
        chair = LinkedChair("living", seed=seed)
        chair.arm()
        trace = []
        for verb in (codes.LEFT, codes.FORWARD):
            chair.press(verb)
            for _ in range(800):
                chair.one_ms()
                trace.append((*chair.world.pose, *chair.world.wipers, chair.world.relay.closed))
        traces.append(trace)
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
    chair = LinkedChair()
    chair.arm()
    chair.press(codes.FORWARD if bit in (codes.WIPER, codes.EMERGENCY) else codes.LEFT)
    chair.run(400)
    chair.world.faults.inject(fault)
    if fault == "wiper_stuck":
        chair.release()  # it shows as soon as another value is written
    seen = 0
    for _ in range(40):
        chair.run(10)
        seen |= chair.app.safety.faults
    assert seen >> bit & 1, f"{seen:#x}"


def test_power_that_comes_back_finds_the_devices_cold():
    """Both hang on the board's 3.3 V: wipers in the middle, a sensor that starts for 400 ms."""
    chair = LinkedChair()
    chair.arm()
    bus, one = BankI2C(chair.bank.buffer, 1), bytearray(1)
    chair.board.power_off()
    chair.run(1000)
    with pytest.raises(OSError, match="19"):
        bus.readfrom_mem_into(0x28, 0x00, one)
    chair.board.power_on()
    for ms in range(1, 450):
        chair.one_ms()
        if ms < BOOT_MS:
            assert chair.wipers() == (0x80, 0x80)
        elif ms < 400:
            assert chair.neutral()  # before its first tick
            with pytest.raises(OSError, match="19"):
                bus.readfrom_mem_into(0x28, 0x00, one)
    bus.readfrom_mem_into(0x28, 0x00, one)
    assert one[0] == 0xA0
    chair.release()
    chair.arm()


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


def test_a_chair_that_stands_sees_what_comes_and_goes():
    """The previous turn's ranges are reused only while nothing moves."""
    world = World(Bank.in_memory(), "open")
    world.lidar.receive(b"\xa5\x20")

    def ahead_m() -> float:
        sent = b"".join(world.step(0.001) for _ in range(200))
        nodes = struct.iter_unpack("<BHH", sent[len(sent) % 5 :])
        return max(quarters for _, angle, quarters in nodes if 0 < angle >> 7 < 2) / 4000.0

    def empty() -> bool:
        return ahead_m() == pytest.approx(hall_m, abs=0.05)

    ahead_m(), ahead_m(), ahead_m()  # its motor spins up
    hall_m = ahead_m()
    assert hall_m > 3.0
    world.faults.inject("obstacle", ahead_m=2.0)
    assert ahead_m() < 1.6
    world.faults.clear("obstacle")
    assert empty()
    world.room.people = (Person(((2.0, 0.0),)),)
    assert ahead_m() < 1.6
    world.room.people = ()
    assert empty()
    world.teleport(0.0, 0.0, 180.0)
    world.faults.inject("obstacle", ahead_m=2.0)  # before it, where it looks now
    assert ahead_m() < 1.6
    world.teleport(0.0, 0.0, 0.0)
    assert empty()
