# Motion: turns the permitted command into joystick outputs.
#
# Step, continuous and proportional. Pure: one tick of 1 ms, no I/O, no clock, no allocation,
# integers only. Only called with permission from safety; anything else is stop().

from gazeboard.core import limits
from gazeboard.core.angle import wrapped
from gazeboard.core.stopping import Stopping
from gazelink import codes
from gazelink.native import micropython

_WORD = (
    codes.STOPPED,
    codes.MOVING_FORWARD,
    codes.MOVING_BACKWARD,
    codes.TURNING,
    codes.TURNING,
    codes.DRIVING,
)
_NEAR_Q4 = 32  # 2 degrees
# Slower than 10 degrees/s: a chair whose stick has left the turn may be held.
_STRAIGHT_Q4_DPS = 160
_LAST_MOVE_MS = 2000  # before a step turn's time is up: a correction takes as long


class Motion:
    # settings: a Settings; turn: a TurnController.

    def __init__(self, settings, turn):
        self._settings = settings
        self._turn = turn
        self._follow = turn.follow  # in each tick: found once
        self._turned = turn.update
        self._held = turn.hold
        # What makes a chair creep straight on that may be the fastest.
        self._creep_forward = Stopping(settings, codes.DIR_FORWARD, False).permille[0]
        self._creep_backward = Stopping(settings, codes.DIR_BACKWARD, False).permille[0]
        self._edge = 0
        self._elapsed_ms = 0
        self._heading_q4 = 0  # at the beginning of the motion
        self._setpoint_q4 = 0  # of the newest step turn
        self._arrived = False  # there, and no other motion since
        self._drives_straight = False  # a heading is held while the stick points straight ahead
        self.linear_permille = 0
        self.turn_permille = 0
        self.state = codes.STOPPED
        self.ended = False  # the motion came to its own end in this tick, for `end_reason`
        self.end_reason = codes.NO_REASON

    # A tick without permission: neutral at once; the setpoint is forgotten.
    @micropython.native
    def stop(self):
        self._halt()
        self._follow(0)

    @micropython.native
    def _halt(self):
        self._edge = 0
        self.linear_permille = 0
        self.turn_permille = 0
        self.state = codes.STOPPED
        self.ended = False

    # One tick of the permitted command `i`; `blocked` has a bit per direction, `caps` the most
    # output per direction, permille; `faults` are the safety core's; `arcs` is obstacles.Arcs, or
    # None where nothing but the caps limits; missed_ms passed without a tick before this one.
    @micropython.native
    def step(self, i, blocked, caps, faults=0, arcs=None, missed_ms=0):
        if i.edge != self._edge:
            self._begin(i)
            missed_ms = 0  # before it began
        verb = i.verb
        mode = i.mode
        if verb == codes.DRIVE:
            linear = i.linear_permille
            turn = i.turn_permille
            if linear and turn:
                self._drives_straight = False
                self._drive_both(i.cap_permille, linear, turn, caps, arcs)
            else:
                self._drive(i, faults)
                self._limit(i, verb, blocked, caps, arcs)
        else:
            self.linear_permille = 0
            self.turn_permille = 0
            if mode == codes.CONTINUOUS:
                self._hold(verb)
            elif mode == codes.STEP:
                self._step_on(i, verb, missed_ms)
            else:
                self._pulse(i, missed_ms)
            if self.state == codes.MOVING_FORWARD and mode != codes.TUNE:
                self._keep_straight(i, faults)
            self._limit(i, verb, blocked, caps, arcs)
        if faults and faults & codes.TILT_LOST:
            linear = self.linear_permille
            self.linear_permille = max(-self._creep_backward, min(self._creep_forward, linear))
        self._follow(self.turn_permille)

    # Within the settings, the command's cap and what obstacles permit.
    @micropython.native
    def _limit(self, i, verb, blocked, caps, arcs):
        s = self._settings
        cap = i.cap_permille
        linear = self.linear_permille
        if linear:
            most = s.linear_permille
            if cap < most:
                most = cap
            way = caps[codes.DIR_FORWARD if linear > 0 else codes.DIR_BACKWARD]
            if way < most:
                most = way
            if arcs is not None and arcs.linear_cap < most:
                most = arcs.linear_cap
            if linear > most:
                self.linear_permille = most
            elif linear < -most:
                self.linear_permille = -most
        turn = self.turn_permille
        if turn == 0:
            return
        if verb == codes.FORWARD or linear:
            most = s.hold_permille
        elif i.mode != codes.CONTINUOUS and verb != codes.DRIVE:
            most = s.step_turn_permille
        else:
            most = s.turn_permille
        if cap < most:
            most = cap
        way = caps[codes.DIR_LEFT if turn > 0 else codes.DIR_RIGHT]
        if way < most:
            most = way
        if arcs is not None and arcs.turn_cap < most:
            most = arcs.turn_cap
        if turn > most:
            turn = most
        elif turn < -most:
            turn = -most
        # A controller's correction may oppose the command's direction: it must not enter a blocked
        # one.
        if (turn > 0 and blocked & (1 << codes.DIR_LEFT)) or (
            turn < 0 and blocked & (1 << codes.DIR_RIGHT)
        ):
            turn = 0
        self.turn_permille = turn

    # What obstacles take from one axis is taken from the other in proportion, so that the driver's
    # curve stays the same. Nothing negative is divided.
    @micropython.viper
    def _drive_both(self, cap: int, linear: int, turn: int, caps, arcs):
        s = self._settings
        back = linear < 0
        right = turn < 0
        most_linear = int(caps[1]) if back else int(caps[0])
        most_turn = int(caps[3]) if right else int(caps[2])
        if back:
            linear = 0 - linear
        if right:
            turn = 0 - turn
        most = int(s.linear_permille)
        if cap < most:
            most = cap
        if linear > most:
            linear = most
        most = int(s.turn_permille)
        if cap < most:
            most = cap
        if turn > most:
            turn = most
        if arcs:
            most = int(arcs.linear_cap)
            if most < most_linear:
                most_linear = most
            most = int(arcs.turn_cap)
            if most < most_turn:
                most_turn = most
        if linear > most_linear:
            turn = turn * most_linear // linear
            linear = most_linear
        if turn > most_turn:
            linear = linear * most_turn // turn
            turn = most_turn
        if back:
            linear = 0 - linear
        if right:
            turn = 0 - turn
        self.linear_permille = linear
        self.turn_permille = turn

    @micropython.native
    def _begin(self, i):
        self._edge = i.edge
        self.ended = False
        self._elapsed_ms = 0
        self._heading_q4 = i.heading_q4
        self.state = _WORD[i.verb]
        if i.mode == codes.STEP:
            angle_q4 = self._settings.step_turn_q4_deg
            if i.verb == codes.LEFT:
                self._setpoint_q4 = self._from_q4(i.heading_q4) + angle_q4
                self._turn.start(self._setpoint_q4, i.heading_count)
            elif i.verb == codes.RIGHT:
                self._setpoint_q4 = self._from_q4(i.heading_q4) - angle_q4
                self._turn.start(self._setpoint_q4, i.heading_count)
        if i.verb == codes.FORWARD:
            self._turn.keep(i.heading_q4)
        self._drives_straight = False
        self._arrived = False

    # Where a step turn begins: at the heading, or at the setpoint that the step before reached and
    # where the chair still stands, so that small errors do not add up.
    @micropython.native
    def _from_q4(self, heading_q4):
        if self._arrived and -_NEAR_Q4 <= wrapped(self._setpoint_q4 - heading_q4) <= _NEAR_Q4:
            return self._setpoint_q4
        return heading_q4

    @micropython.native
    def _hold(self, verb):
        if verb == codes.FORWARD:
            self.linear_permille = self._settings.linear_permille
        elif verb == codes.BACKWARD:
            self.linear_permille = -self._settings.linear_permille
        elif verb == codes.LEFT:
            self.turn_permille = self._settings.turn_permille
        else:
            self.turn_permille = -self._settings.turn_permille

    # A stick that points straight ahead holds the heading, too, once the chair hardly turns.
    @micropython.native
    def _drive(self, i, faults):
        linear = i.linear_permille
        turn = i.turn_permille
        self.linear_permille = linear
        self.turn_permille = turn
        if turn or linear <= 0:
            self._drives_straight = False
        elif self._drives_straight:
            self._keep_straight(i, faults)
        elif -_STRAIGHT_Q4_DPS < i.rate_q4 < _STRAIGHT_Q4_DPS:
            self._drives_straight = True
            self._turn.keep(i.heading_q4)

    # Time is counted in steps only: a held motion may last longer than a small integer can count.
    @micropython.native
    def _step_on(self, i, verb, missed_ms):
        elapsed_ms = self._elapsed_ms + 1 + missed_ms
        self._elapsed_ms = elapsed_ms
        if verb == codes.FORWARD or verb == codes.BACKWARD:
            if elapsed_ms > self._settings.step_forward_ms:
                self._end(codes.NO_REASON)
            else:
                self._hold(verb)
                self._smooth()
            return
        turn = self._turn
        limit_ms = self._settings.step_turn_limit_ms
        if limit_ms <= elapsed_ms + _LAST_MOVE_MS <= limit_ms + missed_ms:
            turn.settle()
        self.turn_permille = self._turned(i.heading_q4, i.rate_q4, i.heading_count)
        if turn.arrived:
            self._arrived = True
            self._end(codes.NO_REASON)
        elif turn.missed or elapsed_ms > limit_ms:
            self._end(codes.TIME_LIMIT)

    # A step straight ahead begins and ends gently, within its time.
    @micropython.native
    def _smooth(self):
        ramp_ms = self._settings.step_ramp_ms
        ms = min(self._elapsed_ms, self._settings.step_forward_ms + 1 - self._elapsed_ms)
        if ms < ramp_ms:
            self.linear_permille = self.linear_permille * ms // ramp_ms

    # The heading is held while going forward, not backward: which way a chair turns then for the
    # same joystick is not known. Without a heading the chair goes on unheld; the sensor may count
    # from another zero afterwards, so the heading then is the one to hold.
    @micropython.native
    def _keep_straight(self, i, faults):
        if faults & codes.HEADING_FAULTS:
            self._turn.keep(i.heading_q4)
        else:
            self.turn_permille = self._held(i.heading_q4, i.rate_q4)

    # One open-loop pulse, at most TUNE_PULSE_MAX_MS long and tune_angle wide.
    @micropython.native
    def _pulse(self, i, missed_ms):
        self._elapsed_ms += 1 + missed_ms
        if self._elapsed_ms > min(i.pulse_ms, limits.TUNE_PULSE_MAX_MS):
            self._end(codes.NO_REASON)
            return
        angle_q4 = wrapped(i.heading_q4 - self._heading_q4)
        most_q4 = self._settings.tune_angle_q4_deg
        if not -most_q4 < angle_q4 < most_q4:
            self._end(codes.TUNING_ANGLE)
        elif i.verb == codes.FORWARD:
            self.linear_permille = abs(i.linear_permille)
        elif i.verb == codes.BACKWARD:
            self.linear_permille = -abs(i.linear_permille)
        elif i.verb == codes.LEFT:
            self.turn_permille = abs(i.turn_permille)
        else:
            self.turn_permille = -abs(i.turn_permille)

    @micropython.native
    def _end(self, reason):
        self._halt()
        self.ended = True
        self.end_reason = reason
