# The requests in the host's frames, as inputs: command, order, clearance, bypass and others.
#
# Frames arrive here checked and in order; `age_ms` is what passed since the host sent one. Each
# refused one is counted. No allocation.

from gazeboard.core import limits
from gazeboard.core.safety import ahead
from gazelink import arcs, codes, messages
from gazelink.frame import i16, u16

_VERB = messages.COMMAND.offsets["verb"]
_MODE = messages.COMMAND.offsets["mode"]
_EDGE = messages.COMMAND.offsets["edge"]
_OWNER = messages.COMMAND.offsets["owner"]
_TTL = messages.COMMAND.offsets["ttl_ms"]
_LINEAR = messages.COMMAND.offsets["linear_permille"]
_TURN = messages.COMMAND.offsets["turn_permille"]
_CAP = messages.COMMAND.offsets["cap_permille"]
_PULSE = messages.COMMAND.offsets["pulse_ms"]
_ACTION = messages.ORDER.offsets["action"]
_NUMBER = messages.ORDER.offsets["number"]
_ORDER_OWNER = messages.ORDER.offsets["owner"]
_BLOCKED = messages.CLEARANCE.offsets["blocked"]
_UNSEEN = messages.CLEARANCE.offsets["unseen"]
_SOURCE = messages.CLEARANCE.offsets["source"]
_FORWARD_MM = messages.CLEARANCE.offsets["forward_mm"]
_BACKWARD_MM = messages.CLEARANCE.offsets["backward_mm"]
_LEFT_Q4 = messages.CLEARANCE.offsets["left_q4_deg"]
_RIGHT_Q4 = messages.CLEARANCE.offsets["right_q4_deg"]
_AGE = messages.CLEARANCE.offsets["age_ms"]
_ARC_VIEWS = messages.CLEARANCE.offsets["arc_views"]
_ARCS = messages.CLEARANCE.offsets["arcs"]
_WATCHED = messages.SUPERVISION.offsets["edge"]
_WATCHER = messages.SUPERVISION.offsets["owner"]
_WATCHED_AGE = messages.SUPERVISION.offsets["age_ms"]
_BYPASS_NUMBER = messages.BYPASS.offsets["number"]
_BYPASS_TTL = messages.BYPASS.offsets["ttl_ms"]
_REQUEST = messages.SETTING.offsets["request"]
_INDEX = messages.SETTING.offsets["index"]
_VALUE = messages.SETTING.offsets["value"]


class Incoming:
    def __init__(self, inbox):
        self._inbox = inbox
        self._order_numbers = bytearray(len(codes.ORDERS))  # newest of each kind, 0: none yet
        self._arcs = (bytearray(arcs.SIZE), bytearray(arcs.SIZE))
        self.setting_pending = False  # a request waits below for the app's answer
        self.setting_request = 0
        self.setting_index = 0
        self.setting_value = 0
        self.stale = 0
        self.bad = 0

    # Refused: not what this board takes.
    def refuse(self):
        self.bad = (self.bad + 1) & 0xFFFF

    # Refused: too late or not in order.
    def late(self):
        self.stale = (self.stale + 1) & 0xFFFF

    # A session has begun: presses and orders are numbered anew.
    def begin(self):
        back = self._inbox.back
        back.session_count = (back.session_count + 1) & 0xFFFF or 1
        back.edge = 0
        for action in range(len(codes.ORDERS)):
            self._order_numbers[action] = 0
        self.forget()

    # Nothing that was requested counts any more.
    def forget(self):
        back = self._inbox.back
        back.verb = codes.STOP
        back.ttl_ms = 0
        back.bypass_ttl_ms = 0
        back.supervision_edge = 0
        self._inbox.touch()

    def take(self, kind, buf, age_ms):
        back = self._inbox.back
        if kind == messages.COMMAND.type_id:
            self._on_command(buf, back, age_ms)
        elif kind == messages.ORDER.type_id:
            self._on_order(buf, back, age_ms)
        elif kind == messages.CLEARANCE.type_id:
            self._on_clearance(buf, back, age_ms)
        elif kind == messages.BYPASS.type_id:
            self._on_bypass(buf, back, age_ms)
        elif kind == messages.SUPERVISION.type_id:
            self._on_supervision(buf, back, age_ms)
        elif kind == messages.SETTING.type_id:
            self._on_setting(buf)
        else:
            self.refuse()

    def _on_command(self, buf, back, age_ms):
        verb = buf[_VERB]
        if verb == codes.STOP:
            back.verb = codes.STOP
            back.stop_edge = back.edge  # pressed before this stop: spent by it
            back.stop_count = (back.stop_count + 1) & 0xFFFF
            return
        linear = i16(buf, _LINEAR)
        turn = i16(buf, _TURN)
        if (
            verb > codes.DRIVE
            or buf[_MODE] > codes.AUTO
            or not -1000 <= linear <= 1000
            or not -1000 <= turn <= 1000
            or u16(buf, _CAP) > 1000
        ):
            self.refuse()
            return
        if age_ms > limits.FRAME_STALE_MS:
            self.late()
            return
        if buf[_EDGE] != back.edge or buf[_OWNER] != back.owner:
            back.press_count = (back.press_count + 1) & 0xFFFF
        back.verb = verb
        back.mode = buf[_MODE]
        back.edge = buf[_EDGE]
        back.owner = buf[_OWNER]
        back.linear_permille = linear
        back.turn_permille = turn
        back.cap_permille = u16(buf, _CAP)
        back.pulse_ms = u16(buf, _PULSE)
        back.ttl_ms = max(0, u16(buf, _TTL) - age_ms)  # counted from when the host sent it
        back.command_count = (back.command_count + 1) & 0xFFFF

    # Each kind has its own number and its own counter: a repeated order counts once, and none takes
    # another's place within a slice.
    def _on_order(self, buf, back, age_ms):
        action = buf[_ACTION]
        number = buf[_NUMBER]
        owner = buf[_ORDER_OWNER]
        if action > codes.RESET_FAULTS or number == 0:
            self.refuse()
        elif action == codes.EMERGENCY_STOP:
            back.emergency_count = (back.emergency_count + 1) & 0xFFFF
        elif action == codes.DISARM:
            if number != self._order_numbers[action]:
                self._order_numbers[action] = number
                back.disarm_count = (back.disarm_count + 1) & 0xFFFF
        elif age_ms > limits.FRAME_STALE_MS:
            self.late()
        elif (action == codes.ARM and owner != codes.DRIVER and owner != codes.CARETAKER) or (
            action == codes.RESET_FAULTS and owner != codes.CARETAKER
        ):
            self.refuse()
        elif ahead(number, self._order_numbers[action]):
            self._order_numbers[action] = number
            if action == codes.ARM:
                back.arm_owner = owner
                back.arm_count = (back.arm_count + 1) & 0xFFFF
            else:
                back.reset_count = (back.reset_count + 1) & 0xFFFF

    def _on_clearance(self, buf, back, age_ms):
        if buf[_SOURCE] > codes.REPLAYED:
            self.refuse()
            return
        back.clearance_blocked = buf[_BLOCKED]
        back.clearance_unseen = buf[_UNSEEN]
        back.clearance_forward_mm = u16(buf, _FORWARD_MM)
        back.clearance_backward_mm = u16(buf, _BACKWARD_MM)
        back.clearance_left_q4 = u16(buf, _LEFT_Q4)
        back.clearance_right_q4 = u16(buf, _RIGHT_Q4)
        back.clearance_source = buf[_SOURCE]
        back.clearance_age_ms = min(limits.AGE_MAX_MS, u16(buf, _AGE) + age_ms)
        back.clearance_arc_views = buf[_ARC_VIEWS]
        # The tick may be reading the other one.
        ways = self._arcs[0]
        if ways is self._inbox.front.clearance_arcs:
            ways = self._arcs[1]
        for k in range(arcs.SIZE):
            ways[k] = buf[_ARCS + k]
        back.clearance_arcs = ways
        back.clearance_count = (back.clearance_count + 1) & 0xFFFF

    def _on_bypass(self, buf, back, age_ms):
        if age_ms > limits.FRAME_STALE_MS:
            self.late()
            return
        if buf[_BYPASS_NUMBER] != back.bypass_number:
            back.press_count = (back.press_count + 1) & 0xFFFF
        back.bypass_number = buf[_BYPASS_NUMBER]
        back.bypass_ttl_ms = max(0, u16(buf, _BYPASS_TTL) - age_ms)
        back.bypass_count = (back.bypass_count + 1) & 0xFFFF

    def _on_supervision(self, buf, back, age_ms):
        if buf[_WATCHER] != codes.DRIVER and buf[_WATCHER] != codes.CARETAKER:
            self.refuse()
        elif age_ms > limits.FRAME_STALE_MS:
            self.late()
        else:
            back.supervision_edge = buf[_WATCHED]
            back.supervision_age_ms = min(limits.AGE_MAX_MS, u16(buf, _WATCHED_AGE) + age_ms)
            back.supervision_count = (back.supervision_count + 1) & 0xFFFF

    # Kept for the app, which owns settings and files; a newer request replaces one not yet
    # answered.
    def _on_setting(self, buf):
        if buf[_REQUEST] > codes.SETTING_SET_NEUTRAL:
            self.refuse()
            return
        self.setting_request = buf[_REQUEST]
        self.setting_index = buf[_INDEX]
        self.setting_value = u16(buf, _VALUE)
        self.setting_pending = True
