# The safety core: given inputs and one tick of 1 ms, decides state, faults and whether the present
# command may move the chair. Pure: no I/O, no clock, no allocation, integers only.
#
# Default answer: no. A command moves the chair only while nothing below speaks against it; the
# first thing that does is kept as the override, and the same press (edge) never moves again.

from gazeboard.core import limits
from gazelink import codes
from gazelink.native import micropython

# Every fault makes neutral, except those that only refuse some directions; and every fault that
# makes neutral ends the armed state at once, except those that may pass.
_WARNING = codes.HEADING_FAULTS | (1 << codes.OBSTACLE_DATA_OLD)
_PASSING = (
    (1 << codes.HOST_SILENT)
    | (1 << codes.SERVICE_STALLED)
    | (1 << codes.TILT)
    | (1 << codes.TILT_UNKNOWN)
)
_NEUTRAL = ~_WARNING
_DISARMING = _NEUTRAL & ~_PASSING
_LATCHED = 0
for _row in codes.FAULTS:
    if _row[3]:
        _LATCHED |= 1 << _row[0]
_ALL_BLOCKED = 15
_ARC_BLOCKED = 256  # obstacles.ARC_BLOCKED; a test compares
_LAST_REASON = codes.FAULT_REASON + len(codes.FAULTS) - 1


@micropython.native
def fault_reason(faults):
    # Reason code of the lowest fault bit set; NO_REASON for none.
    if faults == 0:
        return codes.NO_REASON
    code = codes.FAULT_REASON
    while code < _LAST_REASON and faults & 1 == 0:
        faults >>= 1
        code += 1
    return code


@micropython.native
def older(age_ms):
    # The age one tick later, saturating.
    return age_ms + 1 if age_ms < limits.AGE_MAX_MS else age_ms


@micropython.native
def ahead(edge, newest):
    # Is press `edge` newer than `newest`? They are numbered 1..255 and round; 0: none yet.
    return newest == 0 or 1 <= (edge - newest) & 0xFF <= 127


class Safety:
    # boot_faults: bits found at start. The latched ones clear like any latched fault, the others
    # stand until the next boot.
    def __init__(self, simulated_board, relay_fitted, boot_faults):
        self.state = codes.DISARMED
        self.faults = boot_faults
        self.first_fault = fault_reason(boot_faults)
        self.owner = codes.NOBODY
        self.enable = False  # drive the enable line in this tick
        self.permitted = False  # the command in the inputs may move the chair in this tick
        self.override = codes.NO_REASON
        self.arm_reason = codes.NOT_CONNECTED
        self.blocked = _ALL_BLOCKED  # bits per direction, old data counted as blocked
        self.edge = 0  # press that moves the chair now, 0: none
        self.spent_edge = 0  # press that may not move the chair any more
        self.ttl_ms = 0
        self.missed_ms = 0  # that passed without a tick before the next one: set by the tick
        self._simulated_board = simulated_board
        self._relay_fitted = relay_fitted
        self._standing = boot_faults & ~_LATCHED
        self._verb = codes.STOP  # of the press that moves the chair: a press never changes its mind
        self._mode = codes.STEP
        self._straight = False  # the heading was lost during this drive: it turns no more
        self._quiet = False  # spent_edge ended as asked: nothing to explain
        self._host_age_ms = limits.AGE_MAX_MS
        self._service_age_ms = limits.AGE_MAX_MS
        self._clearance_age_ms = limits.AGE_MAX_MS
        self._heading_age_ms = limits.AGE_MAX_MS
        self._neutral_ms = 0
        self._idle_ms = 0
        self._arming_ms = 0
        self._closed_ms = 0
        self._open_ms = 0
        self._off_ms = 0
        self._steady_ms = limits.AGE_MAX_MS
        self._button_ms = limits.AGE_MAX_MS  # a button pressed at boot is stuck: no reset
        self._wiper_bad = 0
        self._contact = 0  # with none fitted: bit 0 it was open for a while, bit 1 closed
        # Counters of the inputs as last seen
        self._host_count = 0
        self._service_count = 0
        self._command_count = 0
        self._clearance_count = 0
        self._heading_count = 0
        self._session_count = 0
        self._stop_count = 0
        self._emergency_count = 0
        self._disarm_count = 0
        self._arm_count = 0
        self._reset_count = 0

    # Whether a contact tells what the relay does; only while disarmed.
    def set_relay_fitted(self, fitted):
        self._relay_fitted = fitted
        self._contact = 0

    # The joystick's neutral is another count now: it is proven anew. Only while disarmed.
    def neutral_moved(self):
        self._neutral_ms = 0

    # One tick. `i` is an Inputs; `blocked` is that of Obstacles; the contacts are
    # what the pins say now; `late` is true when the time since the last tick exceeded the limit.
    @micropython.native
    def step(self, i, blocked, relay_closed, emergency_open, button_pressed, late):
        self._count_ages(i, relay_closed, button_pressed)
        # Every order has a counter of its own: none takes another's place. An order to arm or to
        # reset that comes with a new session belongs to the old one.
        same_session = self._judge_session(i)
        disarm = i.disarm_count != self._disarm_count
        if disarm:
            self._disarm_count = i.disarm_count
        arms = 0
        count = i.arm_count
        if count != self._arm_count:
            if same_session:
                arms = (count - self._arm_count) & 0xFFFF
            self._arm_count = count
        reset = False
        if i.reset_count != self._reset_count:
            self._reset_count = i.reset_count
            reset = same_session
        if self._button_ms == limits.RESET_PRESS_MS:
            reset = True
        faults = self._judge_faults(i, emergency_open, late, reset)
        if faults and self.faults == 0:
            self.first_fault = fault_reason(faults)
        self.faults = faults
        if disarm:
            self._disarm()
        elif arms:
            self._arm(i.arm_owner, arms, reset)
        self._advance(i)
        self.blocked = _ALL_BLOCKED if faults & (1 << codes.OBSTACLE_DATA_OLD) else blocked
        self._judge_command(i)

    # After the write: did both wipers read back what was written, and was that neutral? Sets the
    # fault at the third failure in a row, before the enable line is toggled. Returns: toggle it
    # now.
    @micropython.native
    def wipers_written(self, verified, neutral):
        if not verified:
            self._neutral_ms = 0
            self._wiper_bad += 1
            if self._wiper_bad >= limits.WIPER_TRIES:
                self._wiper_bad = limits.WIPER_TRIES
                self.trip(codes.WIPER)
            return False
        self._wiper_bad = 0
        self._neutral_ms = older(self._neutral_ms) if neutral else 0
        return self.enable

    # An exception in the tick: enable off, latched.
    @micropython.native
    def tick_raised(self):
        self.trip(codes.TICK_EXCEPTION)

    # Motion came to its own end: reason NO_REASON (done) or TIME_LIMIT.
    @micropython.native
    def finished(self, reason):
        self.permitted = False
        self._end_press(reason)
        self._quiet = reason == codes.NO_REASON

    # Enable off, and a fault that latches: by what is found out after step().
    @micropython.native
    def trip(self, fault):
        if self.faults == 0:
            self.first_fault = codes.FAULT_REASON + fault
        self.faults |= 1 << fault
        self._end_press(codes.FAULT_REASON + fault)
        self._disarm()
        self.arm_reason = self._why_not_arm()

    @micropython.native
    def _disarm(self):
        self.state = codes.DISARMED
        self.owner = codes.NOBODY
        self.enable = False
        self.permitted = False

    # The press that moves the chair, if any, never moves it again.
    @micropython.native
    def _end_press(self, reason):
        if self.edge:
            self.spent_edge = self.edge
            self.edge = 0
            self.override = reason
            self._quiet = False

    @micropython.native
    def _count_ages(self, i, relay_closed, button_pressed):
        if i.host_count != self._host_count:
            self._host_count = i.host_count
            self._host_age_ms = 0
        else:
            self._host_age_ms = older(self._host_age_ms)
        if i.service_count != self._service_count:
            self._service_count = i.service_count
            self._service_age_ms = 0
        else:
            self._service_age_ms = older(self._service_age_ms)
        if i.clearance_count != self._clearance_count:
            self._clearance_count = i.clearance_count
            self._clearance_age_ms = i.clearance_age_ms
        else:
            self._clearance_age_ms = older(self._clearance_age_ms)
        if i.heading_count != self._heading_count:
            self._heading_count = i.heading_count
            self._heading_age_ms = 0
        else:
            self._heading_age_ms = older(self._heading_age_ms)
        if i.command_count != self._command_count:
            self._command_count = i.command_count
            self.ttl_ms = max(0, min(i.ttl_ms, limits.COMMAND_TTL_MS) - limits.MARGIN_MS)
        elif self.ttl_ms > 0:
            self.ttl_ms -= 1
        if self.missed_ms:
            self._count_missed()
        commanded = i.verb != codes.STOP and self.ttl_ms > 0
        self._idle_ms = 0 if commanded else older(self._idle_ms)
        self._closed_ms = older(self._closed_ms) if relay_closed else 0
        self._open_ms = 0 if relay_closed else older(self._open_ms)
        self._off_ms = 0 if self.enable else older(self._off_ms)
        self._button_ms = older(self._button_ms) if button_pressed else 0

    # Time without ticks is in every age, those that begin now included, and in no time for which
    # something has to be proven.
    @micropython.native
    def _count_missed(self):
        ms = self.missed_ms
        self.missed_ms = 0
        self._host_age_ms = min(limits.AGE_MAX_MS, self._host_age_ms + ms)
        self._service_age_ms = min(limits.AGE_MAX_MS, self._service_age_ms + ms)
        self._clearance_age_ms = min(limits.AGE_MAX_MS, self._clearance_age_ms + ms)
        self._heading_age_ms = min(limits.AGE_MAX_MS, self._heading_age_ms + ms)
        self.ttl_ms = max(0, self.ttl_ms - ms)

    # All fault bits of this tick: each condition of the faults table, in one place. A reset clears
    # the latched ones first, so that a cause which stands or comes in this very tick is not lost.
    @micropython.native
    def _judge_faults(self, i, emergency_open, late, reset):
        old = self.faults
        faults = self._standing if reset else old & _LATCHED | self._standing
        if self._host_age_ms >= limits.HOST_SILENT_MS - limits.MARGIN_MS:
            faults |= 1 << codes.HOST_SILENT
        if self._service_age_ms >= limits.SERVICE_STALLED_MS - limits.MARGIN_MS:
            faults |= 1 << codes.SERVICE_STALLED
        limit = limits.CLEARANCE_OLD_MS
        if old & (1 << codes.OBSTACLE_DATA_OLD):
            limit = limits.CLEARANCE_FRESH_MS
        if self._clearance_age_ms >= limit - limits.MARGIN_MS:
            faults |= 1 << codes.OBSTACLE_DATA_OLD
        elif i.clearance_source != codes.REAL and not self._simulated_board:
            faults |= 1 << codes.SIMULATED_SOURCE
        faults |= i.heading_faults & codes.HEADING_FAULTS | i.service_faults
        if self._heading_age_ms >= limits.HEADING_OLD_MS - limits.MARGIN_MS:
            faults |= 1 << codes.HEADING_BUS
        if i.tilted:
            faults |= 1 << codes.TILT
        if not i.calibrated:
            faults |= 1 << codes.CALIBRATION
        if late:
            self._steady_ms = 0
        else:
            self._steady_ms = older(self._steady_ms)
        if self._steady_ms < limits.TICK_STEADY_MS:
            faults |= 1 << codes.TICK_STALLED
        if i.emergency_count != self._emergency_count:
            self._emergency_count = i.emergency_count
            faults |= 1 << codes.EMERGENCY
        if emergency_open:
            faults |= 1 << codes.EMERGENCY
        if self._relay_fitted:
            faults |= self._judge_relay(old)
        else:
            faults |= self._judge_no_relay(reset)
        return faults

    # None is said to be fitted: then no contact moves.
    @micropython.native
    def _judge_no_relay(self, reset):
        if reset:
            self._contact = 0
        if self._open_ms >= limits.RELAY_RELEASE_MS:
            self._contact |= 1
        elif self._closed_ms >= limits.RELAY_RELEASE_MS:
            self._contact |= 2
        return 1 << codes.RELAY_UNEXPECTED if self._contact == 3 else 0

    @micropython.native
    def _judge_relay(self, old):
        if self.state == codes.ARMED:
            if self._open_ms >= limits.RELAY_RELEASE_MS:
                return 1 << codes.RELAY_OPEN
            return 0
        if self.state == codes.ARMING:
            if self._arming_ms >= limits.RELAY_CLOSE_MS and self._closed_ms == 0:
                return 1 << codes.RELAY_OPEN
            return 0
        if min(self._closed_ms, self._off_ms) >= limits.RELAY_STUCK_MS:
            return 1 << codes.RELAY_STUCK
        # Stands until the contact has been open, as it should be now, for a while.
        if min(self._open_ms, self._off_ms) < limits.RELAY_CLEAR_MS:
            return old & ((1 << codes.RELAY_OPEN) | (1 << codes.RELAY_STUCK))
        return 0

    # Another host, or the same one again: nothing of the old life may go on, and its presses are
    # numbered anew. False in the first tick of a session.
    @micropython.native
    def _judge_session(self, i):
        if i.session_count == self._session_count:
            return True
        self._session_count = i.session_count
        self._end_press(codes.NOT_CONNECTED)
        self.spent_edge = 0
        self._disarm()
        return False

    # The last of `arms` orders was `owner`'s; several at once may have gone to and fro. `reset`:
    # faults are reset in this very tick, and whoever asked to arm has not seen them gone.
    @micropython.native
    def _arm(self, owner, arms, reset):
        if owner != codes.DRIVER and owner != codes.CARETAKER:
            return
        if self.state != codes.DISARMED:
            # Hand-over between people: stop, and wait for the new owner's own press.
            if owner != self.owner or arms > 1:
                self.owner = owner
                self._end_press(codes.NOT_OWNER)
        elif not reset and self._why_not_arm() == codes.NO_REASON:
            self.state = codes.ARMING
            self.owner = owner
            self.first_fault = codes.NO_REASON
            self._arming_ms = 0

    # What stands against arming now; NO_REASON: ready.
    @micropython.native
    def _why_not_arm(self):
        if self._session_count == 0:
            return codes.NOT_CONNECTED
        if self.faults:
            return fault_reason(self.faults)
        if self._neutral_ms < limits.NEUTRAL_PROVEN_MS:
            return codes.NEUTRAL_NOT_PROVEN
        if self._idle_ms < limits.IDLE_MS:
            return codes.COMMAND_ACTIVE
        if self._relay_fitted and self._open_ms == 0:
            return codes.FAULT_REASON + codes.RELAY_STUCK  # the test needs open -> closed
        return codes.NO_REASON

    @micropython.native
    def _advance(self, i):
        if self.state == codes.ARMED:
            if (
                self.faults & _DISARMING
                or self._host_age_ms >= limits.HOST_LOST_MS - limits.MARGIN_MS
                or self._service_age_ms >= limits.SERVICE_LOST_MS - limits.MARGIN_MS
            ):
                self._end_press(fault_reason(self.faults & _NEUTRAL))
                self._disarm()
        elif self.state == codes.ARMING:
            self._arming_ms = older(self._arming_ms)
            if self.faults:
                self._disarm()
            elif self._relay_proven():
                self.state = codes.ARMED
                self._spend(i.edge)  # a press held until now is an old one
                self.override = codes.NO_REASON
                self._quiet = False
        self.enable = self.state != codes.DISARMED
        self.arm_reason = self._why_not_arm() if self.state == codes.DISARMED else codes.NO_REASON

    @micropython.native
    def _relay_proven(self):
        if self._relay_fitted:
            return self._closed_ms >= limits.RELAY_HOLD_MS
        return self._arming_ms >= limits.RELAY_HOLD_MS

    # That press and all before it never move the chair any more.
    @micropython.native
    def _spend(self, edge):
        if edge and ahead(edge, self.spent_edge):
            self.spent_edge = edge

    @micropython.native
    def _judge_command(self, i):
        self.permitted = False
        stopped = i.stop_count != self._stop_count
        if stopped:
            self._stop_count = i.stop_count
        if stopped or i.verb == codes.STOP:
            self._end_press(codes.NO_REASON)
        if stopped:
            self._spend(i.stop_edge)  # what was pressed before the stop, seen here or not
        if i.verb == codes.STOP:
            self.override = codes.NO_REASON
            return
        reason = self._why_not_move(i)
        if reason == codes.NO_REASON:
            self.permitted = True
            if i.edge != self.edge:
                self.spent_edge = self.edge or self.spent_edge
                self.edge = i.edge
                self._verb = i.verb
                self._mode = i.mode
            self.override = codes.NO_REASON
            return
        self._end_press(reason)
        if i.edge != self.spent_edge:
            self._spend(i.edge)
            self.override = reason
            self._quiet = False
        elif self.override == codes.NO_REASON and not self._quiet:
            # The same press again: the reason why it ended stays, unless it ended as asked.
            self.override = reason

    @micropython.native
    def _why_not_move(self, i):
        if self.state != codes.ARMED:
            return codes.NOT_ARMED
        if i.owner != self.owner:
            return codes.NOT_OWNER
        if self.faults & _NEUTRAL:
            return fault_reason(self.faults & _NEUTRAL)
        # Only the press that moves it, and presses newer than all before.
        if i.edge == 0 or (i.edge != self.edge and not ahead(i.edge, self.edge or self.spent_edge)):
            return codes.NEEDS_NEW_COMMAND
        running = i.edge == self.edge
        if running and (i.verb != self._verb or i.mode != self._mode):
            return codes.BAD_COMMAND
        # A step ends by itself; a proportional command never does, whatever its mode says.
        stepping = running and i.mode == codes.STEP and i.verb != codes.DRIVE
        if self.ttl_ms == 0 and not stepping:
            return codes.COMMAND_EXPIRED
        reason = codes.BAD_COMMAND
        if i.verb == codes.FORWARD:
            reason = self._why_not_linear(1)
        elif i.verb == codes.BACKWARD:
            reason = self._why_not_linear(-1)
        elif i.verb == codes.LEFT:
            reason = self._why_not_turn(1)
        elif i.verb == codes.RIGHT:
            reason = self._why_not_turn(-1)
        elif i.verb == codes.DRIVE:
            reason = self._why_not_drive(i, running)
        if reason == codes.NO_REASON and self.blocked & _ARC_BLOCKED:
            return self._obstacle(_arc_direction(i))
        return reason

    # A press held at rest ends by what would end it in motion: old data ends all of it, a lost
    # heading its turns (P14).
    @micropython.native
    def _why_not_drive(self, i, running):
        if self.faults & (1 << codes.OBSTACLE_DATA_OLD):
            return codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
        reason = self._why_not_linear(i.linear_permille)
        if reason == codes.NO_REASON:
            reason = self._why_not_turn(i.turn_permille)
        if not running:
            self._straight = False
        if self.faults & codes.HEADING_FAULTS:
            self._straight = True
        elif self._straight and i.turn_permille and reason == codes.NO_REASON:
            return codes.NEEDS_NEW_COMMAND
        return reason

    @micropython.native
    def _why_not_linear(self, sign):
        if sign > 0 and self.blocked & (1 << codes.DIR_FORWARD):
            return self._obstacle(codes.DIR_FORWARD)
        if sign < 0 and self.blocked & (1 << codes.DIR_BACKWARD):
            return self._obstacle(codes.DIR_BACKWARD)
        return codes.NO_REASON

    @micropython.native
    def _why_not_turn(self, sign):
        if sign and self.faults & codes.HEADING_FAULTS:
            return fault_reason(self.faults & codes.HEADING_FAULTS)
        if sign > 0 and self.blocked & (1 << codes.DIR_LEFT):
            return self._obstacle(codes.DIR_LEFT)
        if sign < 0 and self.blocked & (1 << codes.DIR_RIGHT):
            return self._obstacle(codes.DIR_RIGHT)
        return codes.NO_REASON

    @micropython.native
    def _obstacle(self, direction):
        if self.faults & (1 << codes.OBSTACLE_DATA_OLD):
            return codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
        if self.blocked & (16 << direction):
            return codes.ABOVE_CREEP
        return codes.OBSTACLE_FORWARD + direction


# What an arc that is not free is told as: the side to which it leads, or a single axis' direction.
@micropython.native
def _arc_direction(i):
    if i.verb != codes.DRIVE:
        return i.verb - codes.FORWARD
    if i.turn_permille:
        return codes.DIR_LEFT if i.turn_permille > 0 else codes.DIR_RIGHT
    return codes.DIR_FORWARD if i.linear_permille > 0 else codes.DIR_BACKWARD
