# The core's tick without the board: inputs set by hand, one call a millisecond, on CPython and
# MicroPython. What watches the chair itself sees nothing wrong here.

from gazeboard.core.motion import Motion
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.safety import Safety
from gazeboard.core.shared import Inputs
from gazeboard.core.tick import PERIOD_US, Tick
from gazeboard.io.settings import Settings
from gazelink import arcs, codes, messages
from gazesim.lockstep import Steps

CLOSES_MS = 3  # the contact follows the enable line
OPENS_MS = 15


class Turn:
    # A turn controller that says what the test wants.

    def __init__(self):
        self.setpoint_q4 = None
        self.out = 300
        self.arrived = False
        self.missed = False
        self.settles = 0
        self.seen = None
        self.followed = None
        self.kept_q4 = None
        self.held = 0
        self.held_at = None

    def start(self, setpoint_q4, count):
        self.setpoint_q4 = setpoint_q4
        self.arrived = False

    def settle(self):
        self.settles += 1

    def update(self, heading_q4, rate_q4, count):
        self.seen = (heading_q4, rate_q4, count)
        return self.out

    def follow(self, turn_permille):
        self.followed = turn_permille

    def keep(self, heading_q4):
        self.kept_q4 = heading_q4

    def hold(self, heading_q4, rate_q4):
        self.held_at = (heading_q4, rate_q4)
        return self.held


class Watch:
    # Obedience and ProfileCheck that say what the test wants.
    agreed = False
    sluggish = False
    wiper_debt = 0

    def step(self, i, linear_permille, turn_permille, armed=False):
        return False

    def wipers_written(self, verified):
        return False


class Clock:
    # A tick clock that says what the test wants.
    owes = False
    late = False


class Core(Steps):
    # Everything is well until a test says otherwise: `host`, `service`, `lidar` and `imu` live,
    # writes are `verified`, the contact follows the enable line unless `contact` is set.

    def __init__(self, relay_fitted=True, simulated=False, boot_faults=0):
        self.i = Inputs()
        self.i.session_count = 1
        self.i.calibrated = True
        self.i.clearance_source = codes.REAL
        self.i.cap_permille = 1000
        self.free()
        self.turn = Turn()
        self.settings = Settings()
        self.safety = Safety(simulated, relay_fitted, boot_faults)
        self.safety.auto.configure(self.settings)
        self.motion = Motion(self.settings, self.turn)
        self.obstacles = Obstacles(self.settings)
        self.watch = Watch()
        self.clock = Clock()
        parts = (self.obstacles, self.watch, self.watch, self.clock)
        self._tick = Tick(self.safety, self.motion, *parts)
        self.host = True
        self.service = True
        self.lidar = True
        self.imu = True
        self.verified = True
        self.emergency = False
        self.button = False
        self.late = False
        self.contact = None
        self.trusted = False  # the chair turns as the selected profile says
        self.hold_ms = 0  # time to live that each tick's command brings; 0: no new command
        self.watched = False  # the auto motion is supervised in each tick
        self.toggled = False
        self._on_ms = 0
        self._off_ms = OPENS_MS

    def closed(self):
        if self.contact is not None:
            return self.contact
        return self._on_ms >= CLOSES_MS or 0 < self._off_ms < OPENS_MS

    def one_ms(self):
        self.tick()

    def tick(self):
        i = self.i
        if self.host:
            i.host_count = (i.host_count + 1) & 0xFFFF
        if self.service:
            i.service_count = (i.service_count + 1) & 0xFFFF
        if self.lidar:
            i.clearance_count = (i.clearance_count + 1) & 0xFFFF
        if self.imu:
            i.heading_count = (i.heading_count + 1) & 0xFFFF
        if self.hold_ms:
            self.command(self.hold_ms)
        if self.watched:
            self.watch_on()
        self.watch.agreed = self.trusted
        self.clock.late = self.late
        tick = self._tick
        before = tick.enable_level
        tick.decide(i, PERIOD_US, self.closed(), self.emergency, self.button)
        self.toggled = tick.written(self.verified, not self.moving()) != before
        self.toggled = self.toggled and self.safety.enable
        self._on_ms = self._on_ms + 1 if self.toggled else 0
        self._off_ms = 0 if self.toggled else self._off_ms + 1

    # -- what people do ----------------------------------------------------------------------------

    def command(self, ttl_ms):
        self.i.ttl_ms = ttl_ms
        self.i.command_count = (self.i.command_count + 1) & 0xFFFF

    # A new press, held from now on when hold_ms is given.
    def press(self, verb, mode=codes.CONTINUOUS, ttl_ms=300, hold_ms=300):
        i = self.i
        i.verb = verb
        i.mode = mode
        i.edge = i.edge % 255 + 1
        i.owner = codes.DRIVER
        i.press_count = (i.press_count + 1) & 0xFFFF
        self.hold_ms = hold_ms
        self.command(ttl_ms)

    # A new press that nobody holds: held on by its planner and supervised, from now on.
    def auto(self, linear=500, turn=0, hold_ms=150):
        self.i.linear_permille = linear
        self.i.turn_permille = turn
        self.press(codes.DRIVE, codes.AUTO, hold_ms, hold_ms)
        self.watched = True

    # Somebody has just been seen to watch the newest press.
    def watch_on(self, age_ms=0):
        self.i.supervision_edge = self.i.edge
        self.i.supervision_age_ms = age_ms
        self.i.supervision_count = (self.i.supervision_count + 1) & 0xFFFF

    # Nothing is in any way.
    def free(self):
        self.i.clearance_blocked = 0
        self.i.clearance_unseen = 0
        self.i.clearance_forward_mm = messages.CLEAR_FAR
        self.i.clearance_backward_mm = messages.CLEAR_FAR
        self.i.clearance_left_q4 = messages.CLEAR_FAR
        self.i.clearance_right_q4 = messages.CLEAR_FAR
        self.i.clearance_arc_views = 0
        self.i.clearance_arcs = bytearray(arcs.ALL_FAR)

    def release(self):
        self.i.verb = codes.STOP
        self.hold_ms = 0

    def order(self, action, owner=codes.DRIVER):
        # As the link counts it: a reset is the caretaker's.
        i = self.i
        if action == codes.DISARM:
            i.disarm_count = (i.disarm_count + 1) & 0xFFFF
        elif action == codes.ARM:
            i.arm_owner = owner
            i.arm_count = (i.arm_count + 1) & 0xFFFF
        elif action == codes.EMERGENCY_STOP:
            self.emergency_message()
        elif owner == codes.CARETAKER:
            i.reset_count = (i.reset_count + 1) & 0xFFFF

    # A stop by anyone, while a press may go on.
    def stop(self):
        self.i.stop_edge = self.i.edge
        self.i.stop_count = (self.i.stop_count + 1) & 0xFFFF

    def emergency_message(self):
        self.i.emergency_count = (self.i.emergency_count + 1) & 0xFFFF

    def new_session(self):
        self.i.session_count += 1
        self.i.verb = codes.STOP
        self.i.edge = 0

    # Long enough for obstacles to believe a better view; a clearance a tick takes half its turns.
    def see(self):
        self.run(700)

    def make_ready(self):
        self.until(lambda: self.safety.arm_reason == codes.NO_REASON, 1500)

    def arm(self, owner=codes.DRIVER):
        self.see()
        self.make_ready()
        self.order(codes.ARM, owner)
        self.until(self.armed, 200)

    def drive(self, verb=codes.FORWARD, mode=codes.CONTINUOUS):
        self.arm()
        self.press(verb, mode)
        self.tick()
        assert self.moving(), self.why()

    # -- what tests ask ----------------------------------------------------------------------------

    def moving(self):
        return self.motion.linear_permille != 0 or self.motion.turn_permille != 0

    def armed(self):
        return self.safety.state == codes.ARMED

    def fault(self, bit):
        return self.safety.faults & (1 << bit) != 0

    def only_fault(self, bit):
        return self.safety.faults == 1 << bit

    def why(self):
        s = self.safety
        return (
            f"state {s.state} faults {s.faults:x} override {codes.reason_name(s.override)}"
            f" arm_reason {codes.reason_name(s.arm_reason)} edge {s.edge} spent {s.spent_edge}"
        )


def refused(core, reason):
    # The chair stands, and this is said, now and in the ticks after.
    for _ in range(3):
        core.tick()
        assert not core.moving(), core.why()
        assert core.safety.override == reason, core.why()
    return True
