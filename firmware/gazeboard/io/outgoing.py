# What the board sends: greeting, limits, answers, state, statistics and zone, one frame at a time.
#
# What is due is a flag or a time, never a queue, so a host that reads slowly gets the newest state,
# not old ones. Never blocks; no allocation after construction.

import struct

from gazeboard.core import limits
from gazelink import VERSION, codes, frame, messages

_FRAMES_PER_POLL = 3
_HELLO_MS = 200
_STATS_MS = 200
_ZONE_MS = 250  # one direction each time: a lost one is repeated within a second
_NAME_SIZE = 16


_FLAGS = messages.HELLO.offsets["flags"]
_SESSION = messages.HELLO.offsets["session"]
_NONCE_SESSION = messages.NONCE.offsets["session"]
_NONCE = messages.NONCE.offsets["nonce"]
_EPOCH = messages.NONCE.offsets["epoch"]
_TOKEN = messages.PING.offsets["token_low"]
_REQUEST = messages.SETTING_REPLY.offsets["request"]
_INDEX = messages.SETTING_REPLY.offsets["index"]
_VALUE = messages.SETTING_REPLY.offsets["value"]
_REFUSED = messages.SETTING_REPLY.offsets["refused"]
_KEY = messages.MAINTENANCE.offsets["key"]
_ACCEPTED = messages.MAINTENANCE.offsets["accepted"]
_REASON = messages.MAINTENANCE.offsets["reason"]
_ZONE_DIRECTION = messages.ZONE.offsets["direction"]
_ZONE_POINTS = messages.ZONE.offsets["points"]


class Outgoing:
    # keys: the seeds of the session; nonce: as drawn for it.

    def __init__(self, board, outbox, safety, telemetry, trace, decoder, incoming, keys, nonce):
        self._serial = board.serial
        self._outbox = outbox
        self._safety = safety
        self._telemetry = telemetry
        self._trace = trace
        self._decoder = decoder
        self._incoming = incoming
        self._simulated = board.simulated
        self._encoder = frame.Encoder()
        self._encoder.session = keys
        self._keys = keys
        self._nonce = nonce
        self._wire_at = 0  # in the current frame in the encoder's buffer
        self._wire_end = 0
        self._session = 0  # the host's number, 0: none
        self._hello_at = 0
        self._stats_at = 0
        self._zone = None  # per direction, as it goes over the wire
        self._zone_due = 0  # so many directions at once: all in a session's beginning, or when new
        self._zone_next = 0
        self._zone_at = 0
        self._greet = False
        self._nonce_due = False
        self._limits_due = False
        self._pong = False
        self._answered = False
        self._maintenance_answered = False
        self._maintenance = False
        self.hello = bytearray(messages.HELLO.size)
        name = board.name.encode()[:_NAME_SIZE]
        messages.HELLO.pack(
            self.hello,
            (codes.ROLE_BOARD, 0, frame.schema_hash(), 0, board.boot_id) + VERSION + (name,),
        )
        self.maintenance_key = bytearray(messages.MAINTENANCE.size)
        messages.MAINTENANCE.pack(self.maintenance_key, (messages.MAINTENANCE_KEY, 0, 0))
        self._limits = bytearray(messages.LIMITS.size)
        messages.LIMITS.pack(
            self._limits,
            (
                limits.COMMAND_TTL_MS,
                limits.AUTO_TTL_MS,
                limits.CLEARANCE_OLD_MS,
                limits.WIPER_MIN,
                limits.WIPER_MAX,
                limits.WIPER_SPAN,
            ),
        )
        self._token = bytearray(4)
        self._answer_request = 0  # a newer request may come before the line is free
        self._answer_index = 0
        self._answer_value = 0
        self._answer_refused = 0

    # -- what is due -------------------------------------------------------------------------------

    def greet(self):
        self._greet = True

    def begin(self, session):
        self._session = session
        self._telemetry.restart()
        self._trace.ask(False)
        self._zone_due = len(self._zone)

    # The next hello is due at once.
    def end_session(self):
        self._session = 0
        self._limits_due = False
        self._hello_at = (self._outbox.ticks - _HELLO_MS) & 0x3FFFFFFF

    # The token in buf returns.
    def pong(self, buf):
        for k in range(4):
            self._token[k] = buf[_TOKEN + k]
        self._pong = True

    def answer_setting(self, request, index, value, refused):
        self._answer_request = request
        self._answer_index = index
        self._answer_value = value
        self._answer_refused = refused
        self._answered = True

    def answer_maintenance(self, accepted):
        self._maintenance = accepted
        self._maintenance_answered = True

    # zone: the points of each direction. The host learns of a change at once.
    def tell_zone(self, zone):
        self._zone = zone
        self._zone_due = len(zone)

    # Everything sent, before exiting to the REPL?
    def flushed(self):
        return not self._maintenance_answered and self._wire_at == self._wire_end

    # -- frames ------------------------------------------------------------------------------------

    # What is due, as far as the line takes it. `stats` is the App.
    def poll(self, stats):
        self._drain()
        for _ in range(_FRAMES_PER_POLL):
            if self._wire_at != self._wire_end:
                break
            self._send_next(stats)
            self._drain()

    def _elapsed(self, now, since):
        return (now - since) & 0x3FFFFFFF

    # Encoded when the line is free.
    def _send_next(self, stats):
        now = self._outbox.ticks
        if self._greet or (self._session == 0 and self._elapsed(now, self._hello_at) >= _HELLO_MS):
            self._greet = False
            self._hello_at = now
            self._nonce_due = self._session != 0
            self._send_hello()
        elif self._nonce_due:
            self._nonce_due = False
            self._limits_due = True
            self._send_nonce()
        elif self._limits_due:
            self._limits_due = False
            self._send_limits()
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
        elif self._trace.waits():
            self._trace.take(self._encoder.body)
            self._send(messages.TRACE)

    def _send_hello(self):
        body = self._encoder.body
        self._put(self.hello)
        flags = codes.FLAG_SIMULATED if self._simulated else 0
        if self._safety.state != codes.DISARMED:
            flags |= codes.FLAG_ARMED
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

    def _send_limits(self):
        self._put(self._limits)
        self._send(messages.LIMITS)

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
            self._incoming.stale,
            self._incoming.bad,
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
            body[_KEY + k] = self.maintenance_key[_KEY + k]
        body[_ACCEPTED] = 1 if self._maintenance else 0
        body[_REASON] = codes.NO_REASON if self._maintenance else codes.MAINTENANCE_WHILE_ARMED
        self._send(messages.MAINTENANCE)

    # A payload that never changes.
    def _put(self, packed):
        body = self._encoder.body
        for k in range(messages.HEADER_SIZE, len(packed)):
            body[k] = packed[k]

    def _send(self, message):
        self._wire_end = self._encoder.finish(message, self._outbox.ticks & 0xFFFF)
        self._wire_at = 0

    def _drain(self):
        if self._wire_at < self._wire_end:
            self._wire_at = self._serial.write_some(
                self._encoder.wire, self._wire_at, self._wire_end
            )
