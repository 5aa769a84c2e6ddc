# Load program for 32-bit MicroPython: ticks and link traffic while the heap is locked.
#
# A million ticks and service passes, then millions of fuzz bytes into the link. Prints one line of
# name=number.

import gc
import sys

import micropython
from gazelink import codes, messages
from gazesim.board_rig import Rig

TICKS = int(sys.argv[1])
FUZZ = int(sys.argv[2])
MOTIONS = (
    (codes.FORWARD, codes.STEP),
    (codes.LEFT, codes.CONTINUOUS),
    (codes.FORWARD, codes.CONTINUOUS),
    (codes.RIGHT, codes.STEP),
    (codes.BACKWARD, codes.CONTINUOUS),
    (codes.DRIVE, codes.CONTINUOUS),
    (codes.DRIVE, codes.AUTO),
)


class Locked:
    # One ms of the board with the heap locked; the world and the host act outside it.

    def __init__(self, rig):
        self.rig = rig
        self.reached = set()
        self.allocated = 0

    def ms(self):
        rig = self.rig
        rig.world_ms()
        app = rig.app
        app._gc_at = app.outbox.ticks  # collection is planned, and not measured here
        # The locked heap refuses every allocation but a raised exception, which comes from the
        # emergency buffer; the heap's size shows that one. Reading it is slow: only sometimes.
        ask = rig.now_ms & 63 == 0
        before = gc.mem_alloc() if ask else 0
        micropython.heap_lock()
        try:
            rig.board.tick(app)
            app.service()
            app.service()
        finally:
            micropython.heap_unlock()
        if ask:
            self.allocated += gc.mem_alloc() - before
        self.reached.add((app.safety.state, app.motion.state, app.safety.faults != 0))
        rig.listen()


def locked_ticks(n):
    rig = Rig()
    locked = Locked(rig)
    k = 0
    while k < n:
        second = k // 1000
        if k % 1000 == 0:
            if rig.app.safety.state != codes.ARMED:
                rig.release()
                rig.give(codes.ARM)
            elif second % 8 == 7:
                rig.give(codes.DISARM)
            verb, mode = MOTIONS[second % len(MOTIONS)]
            rig.blocked = 15 if second % 9 == 8 else 0
            rig.host_alive = second % 11 != 10
        if k % 1000 == 400 and rig.app.safety.state == codes.ARMED:
            rig.press(verb, mode, 300, -200)
            rig.watched = mode == codes.AUTO
        if k % 1000 == 900:
            rig.release()
        locked.ms()
        k += 1
    return locked


def fuzzed(n):
    # Random bytes, and real frames with one byte spoilt; counters must account for every frame.
    rig = Rig()
    rig.arm()
    rig.host_alive = False
    link = rig.app.link
    seed = 12345
    exceptions = 0
    motions = 0
    fed = 0
    noise = bytearray(64)
    start_ok = link._decoder.ok
    good = 0
    wrong = 0
    while fed < n:
        for k in range(64):
            seed = (seed * 1103 + 12347) & 0xFFFFFF
            noise[k] = (seed >> 8) & 0xFF
        if fed & 256:
            messages.COMMAND.pack(
                rig.encoder.body,
                (codes.FORWARD, codes.CONTINUOUS, 9, codes.DRIVER, 300, 0, 0, 1000, 0),
            )
            count = rig.encoder.finish(messages.COMMAND, rig.stamp)
            for k in range(count):
                noise[k] = rig.encoder.wire[k]
            noise[seed % (count - 1)] ^= 1 + (seed >> 5) % 255
            noise[count] = 0
        try:
            rig.wire.push(noise, 64)
            rig.world_ms()
            rig.board.tick(rig.app)
            rig.app.service()
            rig.listen()
        except Exception as error:
            exceptions += 1
            sys.print_exception(error)
        motions += not rig.neutral()
        fed += 64
        if fed % 6400 == 0:
            # A good frame after all that noise, after a delimiter, is accepted and counted once.
            before = link._decoder.ok
            rig.wire.push(b"\0", 1)
            rig.send(messages.PING, (1, 2))
            rig.app.service()
            wrong += (link._decoder.ok - before) & 0xFFFF != 1
            good += 1
    wrong += (link._decoder.ok - start_ok) & 0xFFFF != good & 0xFFFF
    wrong += link._decoder.corrupt == 0
    return fed, exceptions, motions, wrong


locked = locked_ticks(TICKS)
fed, exceptions, motions, wrong = fuzzed(FUZZ)
print(
    "allocated=%d ticks=%d reached=%d fuzz=%d exceptions=%d motions=%d counters_wrong=%d"
    % (locked.allocated, TICKS, len(locked.reached), fed, exceptions, motions, wrong)
)
