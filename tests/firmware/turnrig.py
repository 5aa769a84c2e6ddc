# A turn controller whose parts say what the test wants, and what they were asked.

from gazeboard.turning.turn import TurnController

GO = 0  # phases
COUNTER = 1
COAST = 2
START = 3
HALF_TURN = 180 << 16
LIMIT = 700
DEADBAND = 56
CUTOFF_Q8 = 256


class Model:
    def __init__(self):
        self.dead_ms = 140
        self.lag_ms = 350
        self.state = [0]
        self.angle_q16 = 0
        self.rate_q10 = 0
        self.is_steady = False
        self.is_let_go = True
        self.slower_than = None  # what was asked for
        self.is_slower = True
        self.halts_at = None  # its angle when it is halted
        self.stepped = None

    def step(self, permille):
        self.stepped = permille
        return 4321

    def seen_angle(self):
        return self.angle_q16

    def seen_rate(self):
        return self.rate_q10

    def steady(self):
        return self.is_steady

    def let_go(self):
        return self.is_let_go

    def slower(self, rate_q10):
        self.slower_than = rate_q10
        return self.is_slower

    def halt(self):
        self.angle_q16 = self.halts_at


class Casters:
    def __init__(self, fitted):
        self.any = fitted
        self.calls = []
        self.adds_q8 = {}  # by the way that is asked about
        self.rest_q8 = 0

    def advance(self, angle_q16):
        self.calls.append(("advance", angle_q16))

    def mark(self):
        self.calls.append(("mark",))

    def skip(self, angle_q16):
        self.calls.append(("skip", angle_q16))

    def watch(self, beside_q8):
        self.calls.append(("watch", beside_q8))

    def learn(self, beside_q8):
        self.calls.append(("learn", beside_q8))
        return self.rest_q8

    def swing_q8(self, way_q8):
        return self.adds_q8[way_q8]


class Plan:
    def __init__(self):
        self.free_q8 = 0
        self.countered_q8 = 0
        self.more = 0
        self.brakes_q8 = 0
        self.asked = None

    def ahead_q8(self, state, seen_q16, side, counters):
        self.asked = (state, seen_q16, side)
        return self.countered_q8 if counters else self.free_q8

    def counters(self, state, side):
        self.asked = (state, side)
        return self.more


class Slope:
    def __init__(self):
        self.drift_q8 = 0
        self.slides_q8 = 0
        self.slides_braked_q8 = 0
        self.calls = []

    def start(self):
        self.calls.append(("start",))

    def learn(self, rest_q8, way_q4, rate_q10):
        self.calls.append(("learn", rest_q8, way_q4, rate_q10))

    def look_ahead(self, way_q8):
        self.calls.append(("look_ahead", way_q8))


class Small:
    def __init__(self):
        self.calls = []
        self.ends_it = False

    def start(self):
        self.calls.append(("start",))

    def begin(self, left_q8, side, bounded):
        self.calls.append(("begin", left_q8, side, bool(bounded)))

    def aim_q8(self, left_q8):
        return left_q8 - 100

    def ends(self, as_planned):
        self.calls.append(("ends", bool(as_planned)))
        return self.ends_it


class Hold:
    def __init__(self):
        self.out = 0
        self.asked = []

    def update(self, error_q4, rate_q4, dt_ms):
        self.asked.append((error_q4, rate_q4, dt_ms))
        return self.out


class Rig:
    # `turn` with all parts scripted; fitted: its casters add something.

    def __init__(self, fitted=False, tuned=1):
        self.model = Model()
        self.casters = Casters(fitted)
        self.left = Plan()
        self.right = Plan()
        self.hold = Hold()
        self.turn = TurnController(
            self.model, self.casters, self.left, self.right, self.hold, DEADBAND, 16, LIMIT, tuned
        )
        self.slope = self.turn._slope = Slope()
        self.small = self.turn._small = Small()
        state, casters, _ = self.turn._looked_at
        self.turn._looked_at = (state, casters, self.slope)
        self.casters.calls = []

    # A turn in this phase, after a first move to `side`, in its first look `left_q8` from there.
    def within(self, phase, side=1, left_q8=0, moves=1):
        turn = self.turn
        turn.start(0, 0)
        turn._begin(side)
        turn._phase = phase
        turn._out = side * LIMIT if phase == GO else -side * LIMIT if phase == COUNTER else 0
        turn._moves = moves
        turn._left_q8 = left_q8
        turn._looked = True
        self.small.calls = []
        return turn

    # One tick with the same sample.
    def tick(self, rate_q4=0, heading_q4=0):
        return self.turn.update(heading_q4, rate_q4, self.turn._count)
