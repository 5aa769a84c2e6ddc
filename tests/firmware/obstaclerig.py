# The obstacle rule with inputs set by hand, and a stick that obeys it.

from gazeboard.core.obstacles import ARC_BLOCKED, Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import arcs, codes
from gazelink.messages import CLEAR_FAR

NAMES = ("clearance_forward_mm", "clearance_backward_mm", "clearance_left_q4", "clearance_right_q4")
TURN_MS = 8


class Eyes:
    # Obstacles with inputs set by hand; a clearance every 20 ms, `age_ms` old when it comes.

    def __init__(self, settings=None, clear=True):
        self.o = Obstacles(settings or Settings())
        self.i = Inputs()
        self.i.session_count = 1
        self.age_ms = 0
        self.linear = 0
        self.turn = 0
        self.armed = True
        self.trusted = False
        self.frames = True
        self.now_ms = 0
        self.i.clearance_arcs = bytearray(arcs.ALL_FAR)
        self.set(CLEAR_FAR)
        if clear:
            self.run(400)

    def set(self, distance, directions=(0, 1, 2, 3)):
        for direction in directions:
            setattr(self.i, NAMES[direction], distance)

    def frame(self):
        self.i.clearance_age_ms = self.age_ms
        self.i.clearance_count = (self.i.clearance_count + 1) & 0xFFFF

    def tick(self):
        if self.frames and self.now_ms % 20 == 0:
            self.frame()
        self.now_ms += 1
        self.o.step(self.i, self.linear, self.turn, self.armed, self.trusted)

    def run(self, ms):
        for _ in range(ms):
            self.tick()

    def hold_bypass(self, number):
        self.i.bypass_number = number
        self.i.bypass_ttl_ms = 300
        self.i.bypass_count = (self.i.bypass_count + 1) & 0xFFFF

    def stopping(self, direction):
        return self.o._stopping[direction + 4 if self.trusted else direction]

    def decision(self, direction):
        decision = self.o.decisions >> (2 * direction) & 3
        blocked = self.o.blocked >> direction & 1
        assert (decision == codes.BLOCKED) == (blocked == 1) == (self.o.caps[direction] == 0)
        return decision

    def way(self, direction):
        return self.o._ways[direction]


def outputs(eyes, direction, permille):
    eyes.linear = (permille, -permille, 0, 0)[direction]
    eyes.turn = (0, 0, permille, -permille)[direction]


# The board with a stick that is held, both its axes put out as asked while nothing blocks.
class Stick(Eyes):
    def __init__(self, linear=0, turn=0, verb=codes.DRIVE):
        super().__init__()
        self.i.cap_permille = 1000
        self.push(linear, turn, verb)

    def push(self, linear, turn, verb=codes.DRIVE):
        self.i.verb = verb
        self.i.linear_permille = linear
        self.i.turn_permille = turn

    # Puts out what is asked for, as the motion does.
    def tick(self):
        super().tick()
        arcs_ = self.o.arcs
        moves = not self.blocked()
        self.linear = within(self.i.linear_permille, arcs_.linear_cap) if moves else 0
        self.turn = within(self.i.turn_permille, arcs_.turn_cap) if moves else 0

    def blocked(self):
        assert self.o.arcs.blocked == (self.o.blocked & ARC_BLOCKED != 0)
        return self.o.arcs.blocked

    def caps(self):
        return (self.o.arcs.linear_cap, self.o.arcs.turn_cap)

    def rows(self, at, count, units):
        for row in range(at, at + count):
            self.i.clearance_arcs[row] = units

    def quadrant(self, quadrant, units):
        self.rows(quadrant * arcs.ROWS, arcs.ROWS, units)


def within(value, cap):
    return max(-cap, min(cap, value))
