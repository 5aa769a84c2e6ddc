# The board's end of the serial link: received bytes to inputs, state to sent bytes.
#
# Never blocks, never allocates. Every rejected frame is counted, none moves the chair. The CRC
# rejects corrupt and foreign frames, and a recording of another session, boot or round of the stamp
# (its seed includes a nonce and the round). The sequence number rejects a reordered or repeated
# frame, the stamp (the echo of the board's clock) a late one. A session ends when the host is
# silent; everything it sent is then invalid.

import struct

from gazeboard.core import limits
from gazeboard.core.safety import ahead
from gazelink import VERSION, arcs, codes, frame, messages
from gazelink.frame import i16, u16

_RX_PER_POLL = 96  # bytes: the slice stays short, and four times the traffic still fits
_FRAMES_PER_POLL = 3
_HELLO_MS = 200
_STATS_MS = 200
_ZONE_MS = 250  # one direction each time: a lost one is repeated within a second
_NAME_SIZE = 16
_ANY_SEQ = -1

_HOST = 0
_BOARD = 1
_SIMULATED_FLAG = 1
_ARMED_FLAG = 2


def _at(message, field):
    return message.offsets[field]


_VERB = _at(messages.COMMAND, "verb")
_MODE = _at(messages.COMMAND, "mode")
_EDGE = _at(messages.COMMAND, "edge")
_OWNER = _at(messages.COMMAND, "owner")
_TTL = _at(messages.COMMAND, "ttl_ms")
_LINEAR = _at(messages.COMMAND, "linear_permille")
_TURN = _at(messages.COMMAND, "turn_permille")
_CAP = _at(messages.COMMAND, "cap_permille")
_PULSE = _at(messages.COMMAND, "pulse_ms")
_ACTION = _at(messages.ORDER, "action")
_NUMBER = _at(messages.ORDER, "number")
_ORDER_OWNER = _at(messages.ORDER, "owner")
_BLOCKED = _at(messages.CLEARANCE, "blocked")
_UNSEEN = _at(messages.CLEARANCE, "unseen")
_SOURCE = _at(messages.CLEARANCE, "source")
_FORWARD_MM = _at(messages.CLEARANCE, "forward_mm")
_BACKWARD_MM = _at(messages.CLEARANCE, "backward_mm")
_LEFT_Q4 = _at(messages.CLEARANCE, "left_q4_deg")
_RIGHT_Q4 = _at(messages.CLEARANCE, "right_q4_deg")
_AGE = _at(messages.CLEARANCE, "age_ms")
_ARC_VIEWS = _at(messages.CLEARANCE, "arc_views")
_ARCS = _at(messages.CLEARANCE, "arcs")
_TOKEN = _at(messages.PING, "token_low")
_ROLE = _at(messages.HELLO, "role")
_FLAGS = _at(messages.HELLO, "flags")
_SCHEMA = _at(messages.HELLO, "schema_hash")
_SESSION = _at(messages.HELLO, "session")
_NONCE_SESSION = _at(messages.NONCE, "session")
_NONCE = _at(messages.NONCE, "nonce")
_EPOCH = _at(messages.NONCE, "epoch")
_PERIOD = _at(messages.TELEMETRY, "state_period_ms")
_BYPASS_NUMBER = _at(messages.BYPASS, "number")
_BYPASS_TTL = _at(messages.BYPASS, "ttl_ms")
_REQUEST = _at(messages.SETTING, "request")
_INDEX = _at(messages.SETTING, "index")
_VALUE = _at(messages.SETTING, "value")
_REFUSED = _at(messages.SETTING_REPLY, "refused")
_KEY = _at(messages.MAINTENANCE, "key")
_ZONE_DIRECTION = _at(messages.ZONE, "direction")
_ZONE_POINTS = _at(messages.ZONE, "points")
_ACCEPTED = _at(messages.MAINTENANCE, "accepted")
_REASON = _at(messages.MAINTENANCE, "reason")


class Link:
    # serial: read_byte() and write_some() as in boards/__init__.py; neither ever waits.

    def __init__(self, board, inbox, outbox, safety, telemetry):
        self._serial = board.serial
        self._inbox = inbox
        self._outbox = outbox
        self._safety = safety
        self._telemetry = telemetry
        self._boot = board.boot_id
        self._decoder = frame.Decoder()
        self._encoder = frame.Encoder()
        self._simulated = board.simulated
        self._wire_at = 0  # in the current frame in the encoder's buffer
        self._wire_end = 0
        self._draw_nonce = board.draw_nonce
        self._session = 0  # the host's number, 0: none
        self._keys = frame.Session()
        self._decoder.session = self._keys
        self._encoder.session = self._keys
        self._nonce = bytearray(4)
        self._last_seq = 0
        self._order_numbers = bytearray(len(codes.ORDERS))  # newest of each kind, 0: none yet
        self._heard_at = 0  # ticks of the last fresh frame
        self._hello_at = 0
        self._stats_at = 0
        self._zone = None  # per direction, as it goes over the wire
        self._zone_due = 0  # so many directions at once: all in a session's beginning, or when new
        self._zone_next = 0
        self._zone_at = 0
        self._greet = False
        self._nonce_due = False
        self._pong = False
        self._answered = False
        self._maintenance_answered = False
        self._hello = bytearray(messages.HELLO.size)
        name = board.name.encode()[:_NAME_SIZE]
        messages.HELLO.pack(
            self._hello, (_BOARD, 0, frame.schema_hash(), 0, board.boot_id) + VERSION + (name,)
        )
        self._key = bytearray(messages.MAINTENANCE.size)
        messages.MAINTENANCE.pack(self._key, (messages.MAINTENANCE_KEY, 0, 0))
        self._arcs = (bytearray(arcs.SIZE), bytearray(arcs.SIZE))
        self.maintenance = False  # the host requested the REPL and nothing prevents it
        self.setting_pending = False  # a request waits below for the app's answer
        self.setting_request = 0
        self.setting_index = 0
        self.setting_value = 0
        self._answer_request = 0  # a newer request may come before the line is free
        self._answer_index = 0
        self._answer_value = 0
        self._answer_refused = 0
        self._token = bytearray(4)
        self.stale = 0
        self.bad = 0

    # One slice: some bytes in, what is due out. `stats` is the App.
    def poll(self, stats):
        self._keys.advance(self._outbox.ticks & 0xFFFF)
        serial = self._serial
        decoder = self._decoder
        for _ in range(_RX_PER_POLL):
            byte = serial.read_byte()
            if byte < 0:
                break
            if decoder.feed(byte):
                self._received()
        if self._session and self._silent_ms() >= limits.HOST_LOST_MS:
            self._end_session()
        self._drain()
        for _ in range(_FRAMES_PER_POLL):
            if self._wire_at != self._wire_end:
                break
            self._send_next(stats)
            self._drain()

    def _elapsed(self, now, since):
        return (now - since) & 0x3FFFFFFF

    def _received(self):
        buf = self._decoder.buf
        kind = buf[messages.TYPE_AT]
        if kind == messages.HELLO.type_id:
            self._on_hello(buf)
        elif kind == messages.MAINTENANCE.type_id:
            self._on_maintenance(buf)
        elif not messages.COMMAND.type_id <= kind < messages.STATE.type_id:
            # Our own message, returned: it does not count as a host frame or for the sequence.
            self.bad = (self.bad + 1) & 0xFFFF
        elif self._in_order(buf):
            back = self._inbox.back
            age_ms = (self._outbox.ticks - u16(buf, messages.STAMP_AT)) & 0xFFFF
            if age_ms <= limits.FRAME_STALE_MS:
                # Only a fresh frame shows that the host lives: a backlog may outlive it. And only
                # one newer than all before: a recording must not block the next ones.
                self._last_seq = buf[messages.SEQ_AT]
                self._heard_at = self._outbox.ticks
                back.host_count = (back.host_count + 1) & 0xFFFF
            self._inbox.touch()
            if kind == messages.COMMAND.type_id:
                self._on_command(buf, back, age_ms)
            elif kind == messages.ORDER.type_id:
                self._on_order(buf, back, age_ms)
            elif kind == messages.CLEARANCE.type_id:
                self._on_clearance(buf, back, age_ms)
            elif kind == messages.BYPASS.type_id:
                self._on_bypass(buf, back, age_ms)
            elif kind == messages.PING.type_id:
                for k in range(4):
                    self._token[k] = buf[_TOKEN + k]
                self._pong = True
            elif kind == messages.SETTING.type_id:
                self._on_setting(buf)
            elif kind == messages.TELEMETRY.type_id and 1 <= buf[_PERIOD] <= 100:
                self._telemetry.period_ms = buf[_PERIOD]
            else:
                self.bad = (self.bad + 1) & 0xFFFF

    def _silent_ms(self):
        return self._elapsed(self._outbox.ticks, self._heard_at)

    # Newer than the last one. A host whose frames got lost for so long that its next one looks old
    # ends its session by that silence.
    def _in_order(self, buf):
        if self._last_seq == _ANY_SEQ:
            return True  # no frame with this session's nonce has come before
        if not 1 <= (buf[messages.SEQ_AT] - self._last_seq) & 0xFF <= 127:
            self.stale = (self.stale + 1) & 0xFFFF
            return False
        return True

    def _on_hello(self, buf):
        if buf[_ROLE] != _HOST:
            return
        session = u16(buf, _SESSION)
        for k in range(4):
            if buf[_SCHEMA + k] != self._hello[_SCHEMA + k]:
                session = 0  # another version: answer, so that it can report it; no session
        self._greet = True
        if session == 0 or session == self._session:
            return
        self._draw_nonce(self._nonce)  # before the first frame of the session can be valid
        self._session = session
        self._keys.begin(session, self._boot, self._nonce, 0, self._outbox.ticks & 0xFFFF)
        self._telemetry.restart()
        self._zone_due = len(self._zone)
        self._last_seq = _ANY_SEQ  # the HELLO may be an old one, its seq, too
        self._heard_at = self._outbox.ticks
        back = self._inbox.back
        back.session_count = (back.session_count + 1) & 0xFFFF or 1
        back.edge = 0
        self._forget(back)
        for action in range(len(codes.ORDERS)):
            self._order_numbers[action] = 0

    # The host's silence has disarmed the chair: its frames do not count any more, even if somebody
    # has recorded them. It must send a new hello.
    def _end_session(self):
        self._session = 0
        self._keys.end()
        self._hello_at = (self._outbox.ticks - _HELLO_MS) & 0x3FFFFFFF  # at once
        self._forget(self._inbox.back)

    def _forget(self, back):
        back.verb = codes.STOP
        back.ttl_ms = 0
        back.bypass_ttl_ms = 0
        self._inbox.touch()

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
            or buf[_MODE] > codes.TUNE
            or not -1000 <= linear <= 1000
            or not -1000 <= turn <= 1000
            or u16(buf, _CAP) > 1000
        ):
            self.bad = (self.bad + 1) & 0xFFFF
            return
        if age_ms > limits.FRAME_STALE_MS:
            self.stale = (self.stale + 1) & 0xFFFF
            return
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
            self.bad = (self.bad + 1) & 0xFFFF
        elif action == codes.EMERGENCY_STOP:
            back.emergency_count = (back.emergency_count + 1) & 0xFFFF
        elif action == codes.DISARM:
            if number != self._order_numbers[action]:
                self._order_numbers[action] = number
                back.disarm_count = (back.disarm_count + 1) & 0xFFFF
        elif age_ms > limits.FRAME_STALE_MS:
            self.stale = (self.stale + 1) & 0xFFFF
        elif (action == codes.ARM and owner != codes.DRIVER and owner != codes.CARETAKER) or (
            action == codes.RESET_FAULTS and owner != codes.CARETAKER
        ):
            self.bad = (self.bad + 1) & 0xFFFF
        elif ahead(number, self._order_numbers[action]):
            self._order_numbers[action] = number
            if action == codes.ARM:
                back.arm_owner = owner
                back.arm_count = (back.arm_count + 1) & 0xFFFF
            else:
                back.reset_count = (back.reset_count + 1) & 0xFFFF

    def _on_clearance(self, buf, back, age_ms):
        if buf[_SOURCE] > codes.REPLAYED:
            self.bad = (self.bad + 1) & 0xFFFF
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
            self.stale = (self.stale + 1) & 0xFFFF
            return
        back.bypass_number = buf[_BYPASS_NUMBER]
        back.bypass_ttl_ms = max(0, u16(buf, _BYPASS_TTL) - age_ms)
        back.bypass_count = (back.bypass_count + 1) & 0xFFFF

    # Kept for the app, which owns settings and files; a newer request replaces one not yet
    # answered.
    def _on_setting(self, buf):
        if buf[_REQUEST] > codes.SETTING_SET_NEUTRAL:
            self.bad = (self.bad + 1) & 0xFFFF
            return
        self.setting_request = buf[_REQUEST]
        self.setting_index = buf[_INDEX]
        self.setting_value = u16(buf, _VALUE)
        self.setting_pending = True

    def answer_setting(self, value, refused):
        self.setting_pending = False
        self._answer_request = self.setting_request
        self._answer_index = self.setting_index
        self._answer_value = value
        self._answer_refused = refused
        self._answered = True

    def _on_maintenance(self, buf):
        for k in range(4):
            if buf[_KEY + k] != self._key[_KEY + k]:
                self.bad = (self.bad + 1) & 0xFFFF
                return
        self.maintenance = self._safety.state == codes.DISARMED
        self._maintenance_answered = True

    # One frame at a time, encoded when the line is free: what is due is a flag or a time, never a
    # queue, so a host that reads slowly gets the newest state, not old ones.
    def _send_next(self, stats):
        now = self._outbox.ticks
        if self._greet or (self._session == 0 and self._elapsed(now, self._hello_at) >= _HELLO_MS):
            self._greet = False
            self._hello_at = now
            self._nonce_due = self._session != 0
            self._send_hello()
        elif self._nonce_due:
            self._nonce_due = False
            self._send_nonce()
        elif self._maintenance_answered:
            self._maintenance_answered = False
            self._send_maintenance()
        elif self._session:
            self._send_in_session(now, stats)

    def _send_in_session(self, now, stats):
        if self._pong:
            self._pong = False
            self._send_pong()
        elif self._answered:
            self._answered = False
            self._send_answer()
        elif self._telemetry.waits():
            stamp_ms = self._telemetry.take(self._encoder.body)
            self._wire_end = self._encoder.finish(messages.STATE, stamp_ms)
            self._wire_at = 0
        elif self._elapsed(now, self._stats_at) >= _STATS_MS:
            self._stats_at = now
            self._send_stats(stats)
        elif self._zone_due or self._elapsed(now, self._zone_at) >= _ZONE_MS:
            self._zone_at = now
            self._zone_due = max(0, self._zone_due - 1)
            self._send_zone()

    def _send_hello(self):
        body = self._encoder.body
        for k in range(messages.HEADER_SIZE, messages.HELLO.size):
            body[k] = self._hello[k]
        flags = _SIMULATED_FLAG if self._simulated else 0
        if self._safety.state != codes.DISARMED:
            flags |= _ARMED_FLAG
        body[_FLAGS] = flags
        body[_SESSION] = self._session & 0xFF
        body[_SESSION + 1] = self._session >> 8
        self._send(messages.HELLO)

    def _send_nonce(self):
        keys = self._keys
        body = self._encoder.body
        body[_NONCE_SESSION] = self._session & 0xFF
        body[_NONCE_SESSION + 1] = self._session >> 8
        for k in range(4):
            body[_NONCE + k] = self._nonce[k]
            body[_EPOCH + k] = (keys.epoch >> (8 * k)) & 0xFF
        self._wire_end = self._encoder.finish(messages.NONCE, keys.clock_ms)
        self._wire_at = 0

    def _send_stats(self, s):
        o = self._outbox
        d = self._decoder
        struct.pack_into(
            messages.STATS.format,
            self._encoder.body,
            messages.HEADER_SIZE,
            d.ok,
            d.corrupt,
            d.unknown,
            self.stale,
            self.bad,
            self._telemetry.dropped,
            min(o.tick_max_us, 65535),
            o.late_ticks,
            min(s.service_max_ms, 65535),
            s.heap_free_kb,
            s.imu_samples(),
            s.imu_errors(),
            s.reset_cause,
            1 if o.relay_closed else 0,
            s.imu_status(),
            self._safety.owner,
            s.speed_mm_s(),
            s.profile_seen(),
            s.bypass_ms(),
        )
        o.tick_max_us = 0
        s.service_max_ms = 0
        self._send(messages.STATS)

    def _send_pong(self):
        body = self._encoder.body
        for k in range(4):
            body[_TOKEN + k] = self._token[k]
        self._send(messages.PONG)

    def _send_answer(self):
        body = self._encoder.body
        body[_REQUEST] = self._answer_request
        body[_INDEX] = self._answer_index
        body[_VALUE] = self._answer_value & 0xFF
        body[_VALUE + 1] = self._answer_value >> 8
        body[_REFUSED] = self._answer_refused
        self._send(messages.SETTING_REPLY)

    # zone: the points of each direction. The host learns of a change at once.
    def tell_zone(self, zone):
        self._zone = zone
        self._zone_due = len(zone)

    def _send_zone(self):
        at = self._zone_next
        self._zone_next = (at + 1) % len(self._zone)
        body = self._encoder.body
        body[_ZONE_DIRECTION] = at
        points = self._zone[at]
        for k in range(len(points)):
            body[_ZONE_POINTS + k] = points[k]
        self._send(messages.ZONE)

    def _send_maintenance(self):
        body = self._encoder.body
        for k in range(4):
            body[_KEY + k] = self._key[_KEY + k]
        body[_ACCEPTED] = 1 if self.maintenance else 0
        body[_REASON] = codes.NO_REASON if self.maintenance else codes.MAINTENANCE_WHILE_ARMED
        self._send(messages.MAINTENANCE)

    def _send(self, message):
        self._wire_end = self._encoder.finish(message, self._outbox.ticks & 0xFFFF)
        self._wire_at = 0

    def _drain(self):
        if self._wire_at < self._wire_end:
            self._wire_at = self._serial.write_some(
                self._encoder.wire, self._wire_at, self._wire_end
            )

    # Everything sent, before exiting to the REPL?
    def flushed(self):
        return not self._maintenance_answered and self._wire_at == self._wire_end
