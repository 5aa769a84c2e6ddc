# The tick allocates nothing, and neither does the service loop with live traffic: proven with the
# heap locked on MicroPython, in every state, through faults and refusals.

from boardtest import no_allocation
from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazelink import codes
from gazesim.board_rig import IMU, POT, Rig

SERVICE_PASSES = 3


def quiet_garbage(rig):
    # Collecting is the service loop's own, planned act; it is not what is measured here.
    rig.app._gc_at = rig.app.outbox.ticks


def ticks(rig, n):
    # n ms of board time with the host's frames prepared beforehand: only the board runs inside.
    for _ in range(n):
        if rig.now_ms % 20 == 0 and rig.host_alive:
            rig.speak()
        rig.now_ms += 1
        rig._relay()
        if rig.now_ms % 10 == 0 and rig.imu_alive:
            rig._sense()
        quiet_garbage(rig)
        no_allocation(lambda: board_only(rig), 1)
        rig.listen()


def board_only(rig):
    rig.clock.now_us += 333
    rig.board.tick(rig.app)
    for _ in range(SERVICE_PASSES):
        rig.app.service()


def test_arming_and_every_motion():
    rig = Rig()
    rig.run(1100)
    ticks(rig, 20)
    rig.give(codes.ARM)
    ticks(rig, 150)
    rig.until(lambda: rig.app.safety.state == codes.ARMED, 200)
    for verb in (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE):
        for mode in (codes.STEP, codes.CONTINUOUS):
            rig.press(verb, mode, 300, -200)
            ticks(rig, 40)
            assert not rig.neutral()
            rig.release()
            ticks(rig, 25)
            assert rig.neutral()


def test_overrides_and_faults():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    ticks(rig, 30)
    rig.blocked = 15
    ticks(rig, 30)
    rig.blocked = 0
    rig.press(codes.LEFT)
    ticks(rig, 30)
    rig.imu_alive = False
    ticks(rig, 60)
    rig.host_alive = False
    ticks(rig, 120)
    assert rig.app.safety.faults & (1 << codes.HOST_SILENT)


def test_corrupt_and_replayed_bytes():
    rig = Rig()
    rig.arm()
    noise = bytearray(40)
    for k in range(300):
        for n in range(40):
            noise[n] = (k * 37 + n * n * 11) & 0xFF
        rig.wire.push(noise, 40)
        ticks(rig, 1)
    assert rig.app.link._decoder.corrupt > 50


def test_bus_errors_allocate_only_the_exception_itself():
    # OSError is raised by the driver below; on the board it comes from the emergency buffer.
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    rig.run(30)
    rig.bank[POT + at.SLOT_NAK] = 1
    rig.bank[IMU + at.SLOT_NAK] = 1
    rig.bank[at.BUSES_AT + pins.IMU_BUS * at.BUS_SIZE] = 1
    rig.run(100)
    assert rig.app.safety.faults & (1 << codes.WIPER)
    ticks_after = rig.app.outbox.ticks
    rig.run(10)
    assert rig.app.outbox.ticks == ticks_after + 10
