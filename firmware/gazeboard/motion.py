# Motion: turns the permitted command into joystick outputs. Step, continuous and proportional.
# Pure: one tick of 1 ms, no I/O, no clock, no allocation, integers only. Only ever called with
# permission from safety; anything else is stop().

from gazelink import codes

_WORD = (
    codes.STOPPED,
    codes.MOVING_FORWARD,
    codes.MOVING_BACKWARD,
    codes.TURNING,
    codes.TURNING,
    codes.DRIVING,
)


class Motion:
    # settings: a Settings; turn: a TurnController.

    def __init__(self, settings, turn):
        self._settings = settings
        self._turn = turn
        self._edge = 0
        self._elapsed_ms = 0
        self.linear_permille = 0
        self.turn_permille = 0
        self.state = codes.STOPPED
        self.ended = False  # the motion came to its own end in this tick, for `end_reason`
        self.end_reason = codes.NO_REASON

    # Neutral at once; the setpoint is forgotten.
    def stop(self):
        self._edge = 0
        self.linear_permille = 0
        self.turn_permille = 0
        self.state = codes.STOPPED
        self.ended = False

    # One tick of the permitted command `i`; `blocked` has a bit per direction.
    def step(self, i, blocked):
        if i.edge != self._edge:
            self._begin(i)
        self._elapsed_ms += 1
        self.linear_permille = 0
        self.turn_permille = 0
        if i.verb == codes.DRIVE:
            self.linear_permille = _clamped(i.linear_permille, self._settings.linear_permille)
            self.turn_permille = _clamped(i.turn_permille, self._settings.turn_permille)
        elif i.verb == codes.FORWARD or i.verb == codes.BACKWARD:
            self._linear(i)
        else:
            self._rotate(i)
        # A controller's correction may point the other way than the command: it only goes where it
        # is free.
        turn = self.turn_permille
        if (turn > 0 and blocked & (1 << codes.DIR_LEFT)) or (
            turn < 0 and blocked & (1 << codes.DIR_RIGHT)
        ):
            self.turn_permille = 0

    def _begin(self, i):
        self._edge = i.edge
        self._elapsed_ms = 0
        self.ended = False
        self.state = _WORD[i.verb]
        if i.mode == codes.STEP and (i.verb == codes.LEFT or i.verb == codes.RIGHT):
            angle_q4 = self._settings.step_turn_q4_deg
            self._turn.start(i.heading_q4 + (angle_q4 if i.verb == codes.LEFT else -angle_q4))

    def _linear(self, i):
        if i.mode == codes.STEP and self._elapsed_ms > self._settings.step_forward_ms:
            self._end(codes.NO_REASON)
            return
        speed = self._settings.linear_permille
        self.linear_permille = speed if i.verb == codes.FORWARD else -speed

    def _rotate(self, i):
        if i.mode == codes.CONTINUOUS:
            speed = self._settings.turn_permille
            self.turn_permille = speed if i.verb == codes.LEFT else -speed
            return
        out = self._turn.update(i.heading_q4, i.rate_q4)
        if self._turn.arrived:
            self._end(codes.NO_REASON)
        elif self._elapsed_ms > self._settings.step_turn_limit_ms:
            self._end(codes.TIME_LIMIT)
        else:
            self.turn_permille = out

    def _end(self, reason):
        self.stop()
        self.ended = True
        self.end_reason = reason


def _clamped(value, limit):
    return max(-limit, min(limit, value))
