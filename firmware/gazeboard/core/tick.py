# The order of a tick: from inputs, contacts and elapsed time to outputs and enable line.
#
# Pure: no devices, no clock, no allocation. The board, the tests, the proof and the benchmarks call
# this one. It has two halves: the wipers are written and read back in between.

from gazeboard.core import limits
from gazelink import codes
from gazelink.const import const
from gazelink.native import micropython

PERIOD_US = 1000
_AUTO = const(3)  # codes.AUTO; a test compares


class Tick:
    # The parts have the faces of Safety, Motion, Obstacles, Obedience, ProfileCheck and TickClock;
    # motion and profile_check are others when settings change.

    def __init__(self, safety, motion, obstacles, obedience, profile_check, clock):
        self.safety = safety
        self.motion = motion
        self.profile_check = profile_check
        self._parts = (safety, obstacles, obedience, clock)  # found at once in each tick
        self.linear_permille = 0  # what the wipers are to be written for
        self.turn_permille = 0
        self.enable_level = 0  # of the enable line: it changes each tick while the relay may close
        self.missed_ms = 0  # that passed without a tick before this one
        self.late = False  # the ticks stall, or come too slowly

    # `i` is an Inputs; elapsed_us: since the tick before; the contacts are what the pins say now.
    @micropython.native
    def decide(self, i, elapsed_us, relay_closed, emergency_open, button_pressed):
        safety, obstacles, obedience, clock = self._parts
        motion = self.motion
        profile_check = self.profile_check
        missed_ms = 0
        if clock.owes or not 0 <= elapsed_us <= limits.TICK_ON_TIME_US:
            missed_ms = clock.step(elapsed_us)
            if missed_ms:
                safety.missed_ms = missed_ms
                obstacles.missed(missed_ms)
        self.missed_ms = missed_ms
        late = clock.late
        self.late = late
        armed = safety.state == codes.ARMED
        obstacles.step(
            i,
            motion.linear_permille,
            motion.turn_permille,
            armed,
            profile_check.agreed,
            profile_check.sluggish,
        )
        blocked = obstacles.blocked
        caps = obstacles.caps
        if armed and i.mode == _AUTO:
            blocked = obstacles.auto_blocked(i)
            caps = obstacles.auto_caps
        safety.step(i, blocked, relay_closed, emergency_open, button_pressed, late)
        if safety.permitted:
            motion.step(i, safety.blocked, caps, safety.faults, obstacles.arcs, missed_ms)
            if motion.ended:
                safety.finished(motion.end_reason)
        else:
            motion.stop()
        linear_permille = motion.linear_permille
        turn_permille = motion.turn_permille
        profile_check.step(i, linear_permille, turn_permille)
        if obedience.step(i, linear_permille, turn_permille, safety.state == codes.ARMED):
            safety.trip(codes.DISOBEYS)
            motion.stop()
            linear_permille = motion.linear_permille
            turn_permille = motion.turn_permille
        self.linear_permille = linear_permille
        self.turn_permille = turn_permille

    # After the write: did both wipers read back what was written, and was that neutral? Returns the
    # level of the enable line.
    @micropython.native
    def written(self, verified, neutral):
        safety, _, obedience, _ = self._parts
        if (not verified or obedience.wiper_debt) and obedience.wipers_written(verified):
            safety.trip(codes.WIPER)
        if safety.wipers_written(verified, neutral):
            self.enable_level ^= 1
        elif not safety.enable:
            self.enable_level = 0
        return self.enable_level

    # An exception in the tick (P1, P10): enable off, the outputs neutral, latched; each for itself,
    # because anything may be what is broken.
    def raised(self):
        self.enable_level = 0
        try:
            self.safety.tick_raised()
        except Exception:
            pass
        try:
            self.motion.stop()
        except Exception:
            pass
