# The safety core: decides state, faults and whether the present command may move the chair.
# Given inputs and one tick of 1 ms. Pure: no I/O, no clock, no allocation, integers only.
#
# The default is no. A command moves the chair only while no check below objects; the first
# objection is kept as the override, and the same press (edge) never moves the chair again.

from gazeboard.core import ages, auto, limits
from gazeboard.core.directions import ARC_BLOCKED, heads, of_arc
from gazelink import codes
from gazelink.native import micropython, ptr32

# Every fault sets the outputs to neutral, except those that only refuse some directions. Every
# fault that does so also disarms at once, except those that may pass.
_WARNING = codes.HEADING_FAULTS | (1 << codes.OBSTACLE_DATA_OLD)
_PASSING = (
    (1 << codes.HOST_SILENT)
    | (1 << codes.SERVICE_STALLED)
    | (1 << codes.TILT)
    | (1 << codes.TILT_UNKNOWN)
)
_NEUTRAL = ~_WARNING
_DISARMING = _NEUTRAL & ~_PASSING
_ALL_BLOCKED = 15
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
        self.missed_ms = 0  # that passed without a tick before the next one: set by the tick
        self._verb = codes.STOP  # of the press that moves the chair: a press never changes its mind
        self._mode = codes.STEP
        self._straight = False  # the heading was lost during this drive: it turns no more
        self._quiet = False  # spent_edge ended as asked: nothing to explain
        self.ages = ages.Ages()
        self._words = words = self.ages.words
        # Found once; not bound, which takes longer to call.
        self._counted = (self.ages, ages.Ages.count, ages.Ages.faults)
        self.auto = auto.Auto(words)
        words[ages.STANDING] = boot_faults & ~ages.LATCHED
        words[ages.SIMULATED] = simulated_board
        words[ages.RELAY_FITTED] = relay_fitted
        self._wiper_bad = 0

    # Whether a contact reports the relay's position. Only while disarmed.
    def set_relay_fitted(self, fitted):
        self._words[ages.RELAY_FITTED] = fitted
        self._words[ages.CONTACT] = 0

    # The joystick's neutral has another count now, so it must be proven again. Only while disarmed.
    def neutral_moved(self):
        self._words[ages.NEUTRAL] = 0

    # One tick. `i` is an Inputs; `blocked` is that of Obstacles; the contacts are
    # what the pins say now; `late` is true when the time since the last tick exceeded the limit.
    @micropython.native
    def step(self, i, blocked, relay_closed, emergency_open, button_pressed, late):
        our_ages, count, find_faults = self._counted
        missed_ms = self.missed_ms
        # Every order has its own counter, so that none replaces another. An order to arm or to
        # reset that arrives together with a new session belongs to the old session.
        news = count(our_ages, i, relay_closed, button_pressed, late, self.enable, missed_ms)
        reset = False
        if news:
            if news & ages.SESSION:
                self._begin_session()
                news &= ~(ages.ARM | ages.RESET)
            reset = news & (ages.RESET | ages.PRESSED) != 0
            if news & ages.EMERGENCY:
                emergency_open = True
        old = self.faults
        faults = find_faults(our_ages, i, old, self.state, emergency_open, reset)
        self.faults = faults
        if faults:
            if old == 0:
                self.first_fault = fault_reason(faults)
            if faults & (1 << codes.OBSTACLE_DATA_OLD):
                blocked = _ALL_BLOCKED
        self.blocked = blocked
        if news:
            if news & ages.DISARM:
                self._disarm()
            elif news & ages.ARM:
                self._arm(i.arm_owner, self._words[ages.ARMS], reset)
            news &= ages.STOPPED
        if faults or self.state != codes.ARMED:
            self._advance(i)
        self._judge_command(i, news)
        if missed_ms:
            self.missed_ms = 0

    # After the write: did both wipers read back what was written, and was that neutral? Sets the
    # fault at the third failure in a row, before the enable line is toggled. Returns: toggle it
    # now.
    @micropython.native
    def wipers_written(self, verified, neutral):
        if not verified:
            self._words[ages.NEUTRAL] = 0
            self._wiper_bad += 1
            if self._wiper_bad >= limits.WIPER_TRIES:
                self._wiper_bad = limits.WIPER_TRIES
                self.trip(codes.WIPER)
            return False
        self._wiper_bad = 0
        self._last(ages.NEUTRAL, neutral)
        return self.enable

    # A duration: one tick longer if the condition holds, else 0.
    @micropython.viper
    def _last(self, at: int, lasts: int):
        w = ptr32(self._words)
        if lasts == 0:
            w[at] = 0
        elif w[at] < int(limits.AGE_MAX_MS):
            w[at] += 1

    # An exception was raised in the tick: enable off, latched fault.
    @micropython.native
    def tick_raised(self):
        self.trip(codes.TICK_EXCEPTION)

    # Motion came to its own end: reason NO_REASON (done) or TIME_LIMIT.
    @micropython.native
    def finished(self, reason):
        self.permitted = False
        self._end_press(reason)
        self._quiet = reason == codes.NO_REASON

    # Enable off and a latched fault, for what is detected after step().
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

    # A new session, of this host or another: nothing of the old session may continue, and presses
    # are numbered from the start.
    @micropython.native
    def _begin_session(self):
        self._end_press(codes.NOT_CONNECTED)
        self.spent_edge = 0
        self._disarm()

    # The last of `arms` orders was `owner`'s; several may have arrived at once. `reset`: the faults
    # are reset in this same tick, so whoever asked to arm has not seen them cleared.
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
            self._words[ages.ARMING] = 0

    # Why arming is refused now; NO_REASON: ready.
    @micropython.native
    def _why_not_arm(self):
        words = self._words
        if words[ages.SESSION_COUNT] == 0:
            return codes.NOT_CONNECTED
        if self.faults:
            return fault_reason(self.faults)
        if words[ages.NEUTRAL] < limits.NEUTRAL_PROVEN_MS:
            return codes.NEUTRAL_NOT_PROVEN
        if words[ages.IDLE] < limits.IDLE_MS:
            return codes.COMMAND_ACTIVE
        if words[ages.RELAY_FITTED] and words[ages.OPEN] == 0:
            return codes.FAULT_REASON + codes.RELAY_STUCK  # the test needs open -> closed
        return codes.NO_REASON

    # Without a fault, what is armed stays armed.
    @micropython.native
    def _advance(self, i):
        state = self.state
        if state == codes.ARMED:
            faults = self.faults
            if faults & _DISARMING or self._lost():
                self._end_press(fault_reason(faults & _NEUTRAL))
                self._disarm()
                state = codes.DISARMED
        elif state == codes.ARMING:
            self._last(ages.ARMING, True)
            if self.faults:
                self._disarm()
                state = codes.DISARMED
            elif self._relay_proven():
                self.state = codes.ARMED
                self._spend(i.edge)  # a press held until now is an old one
                self.override = codes.NO_REASON
                self._quiet = False
        self.enable = state != codes.DISARMED
        self.arm_reason = self._why_not_arm() if state == codes.DISARMED else codes.NO_REASON

    # Silent or stalled for so long that it disarms. Both are faults long before that.
    @micropython.native
    def _lost(self):
        words = self._words
        return (
            words[ages.HOST] >= limits.HOST_LOST_MS - limits.MARGIN_MS
            or words[ages.SERVICE] >= limits.SERVICE_LOST_MS - limits.MARGIN_MS
        )

    @micropython.native
    def _relay_proven(self):
        if self._words[ages.RELAY_FITTED]:
            return self._words[ages.CLOSED] >= limits.RELAY_HOLD_MS
        return self._words[ages.ARMING] >= limits.RELAY_HOLD_MS

    # This press and all before it never move the chair again.
    @micropython.native
    def _spend(self, edge):
        if edge and ahead(edge, self.spent_edge):
            self.spent_edge = edge

    @micropython.native
    def _judge_command(self, i, stopped):
        verb = i.verb
        stops = verb == codes.STOP
        if stopped or stops:
            self._end_press(codes.NO_REASON)
        if stopped:
            self._spend(i.stop_edge)  # what was pressed before the stop, seen here or not
        if stops:
            self.permitted = False
            self.override = codes.NO_REASON
            return
        edge = i.edge
        reason = self._why_not_move(i, verb, edge)
        if reason == codes.NO_REASON:
            self.permitted = True
            if edge != self.edge:
                self.spent_edge = self.edge or self.spent_edge
                self.edge = edge
                self._verb = verb
                self._mode = i.mode
            self.override = codes.NO_REASON
            if self.auto.overruled_ms:
                self.auto.permitted(i)
            return
        self.permitted = False
        if edge == self.edge and i.mode == codes.AUTO and self.auto.waits(reason, self.missed_ms):
            self.override = reason
            return
        self._end_press(reason)
        if edge != self.spent_edge:
            self._spend(edge)
            self.override = reason
            self._quiet = False
        elif self.override == codes.NO_REASON and not self._quiet:
            # The same press again: the reason why it ended stays, unless it ended as asked.
            self.override = reason

    @micropython.native
    def _why_not_move(self, i, verb, edge):
        if self.state != codes.ARMED:
            return codes.NOT_ARMED
        if i.owner != self.owner:
            return codes.NOT_OWNER
        mode = i.mode
        faults = self.faults
        if faults and faults & _NEUTRAL:
            return fault_reason(faults & _NEUTRAL)
        # Only the press that moves it, and presses newer than all before.
        running = edge == self.edge
        if edge == 0 or (not running and not ahead(edge, self.edge or self.spent_edge)):
            return codes.NEEDS_NEW_COMMAND
        if running and (verb != self._verb or mode != self._mode):
            return codes.BAD_COMMAND
        if self._words[ages.TTL] == 0:
            # A step ends by itself; a proportional command never does, whatever its mode says.
            if not running or mode != codes.STEP or verb == codes.DRIVE:
                return codes.COMMAND_EXPIRED
        if mode == codes.AUTO:
            reason = self.auto.why_not(i, running, self.missed_ms)
            if reason != codes.NO_REASON:
                return reason
        blocked = self.blocked
        if running and not faults and not self._straight:
            if not blocked or not blocked & heads(i, verb):
                return codes.NO_REASON  # most ticks: none of what follows can say more
        if verb == codes.FORWARD:
            reason = self._why_not_linear(1)
        elif verb == codes.BACKWARD:
            reason = self._why_not_linear(-1)
        elif verb == codes.LEFT:
            reason = self._why_not_turn(1)
        elif verb == codes.RIGHT:
            reason = self._why_not_turn(-1)
        elif verb == codes.DRIVE:
            reason = self._why_not_drive(i, running)
        else:
            reason = codes.BAD_COMMAND
        if reason == codes.NO_REASON and blocked & ARC_BLOCKED and heads(i, verb):
            return self._obstacle(of_arc(i))
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
