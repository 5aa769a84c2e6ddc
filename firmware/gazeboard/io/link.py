# The board's end of the serial link: the session with the host, frames in and out.
#
# Never blocks, never allocates. Every rejected frame is counted, none moves the chair. The CRC
# rejects corrupt and foreign frames, and a recording of another session, boot or round of the stamp
# (its seed includes a nonce and the round). The sequence number rejects a reordered or repeated
# frame, the stamp (the echo of the board's clock) a late one. A session ends when the host is
# silent; everything it sent is then invalid.

from gazeboard.core import limits
from gazeboard.io.incoming import Incoming
from gazeboard.io.outgoing import Outgoing
from gazelink import codes, frame, messages
from gazelink.frame import u16

_RX_PER_POLL = 96  # bytes: the slice stays short, and four times the traffic still fits
_ANY_SEQ = -1

_ROLE = messages.HELLO.offsets["role"]
_SCHEMA = messages.HELLO.offsets["schema_hash"]
_SESSION = messages.HELLO.offsets["session"]
_PERIOD = messages.TELEMETRY.offsets["state_period_ms"]
_ON = messages.TRACE_REQUEST.offsets["on"]
_KEY = messages.MAINTENANCE.offsets["key"]
_CLEARS = messages.MAINTENANCE.offsets["reason"]


class Link:
    # serial: read_byte() and write_some() as in boards/__init__.py; neither ever waits.

    def __init__(self, board, inbox, outbox, safety, telemetry, trace):
        self._serial = board.serial
        self._inbox = inbox
        self._outbox = outbox
        self._safety = safety
        self._telemetry = telemetry
        self._trace = trace
        self._boot = board.boot_id
        self._draw_nonce = board.draw_nonce
        self._session = 0  # the host's number, 0: none
        self._keys = frame.Session()
        self._decoder = frame.Decoder()
        self._decoder.session = self._keys
        self._nonce = bytearray(4)
        self._last_seq = 0
        self._heard_at = 0  # ticks of the last fresh frame
        self.incoming = Incoming(inbox)
        self.outgoing = Outgoing(
            board,
            outbox,
            safety,
            telemetry,
            trace,
            self._decoder,
            self.incoming,
            self._keys,
            self._nonce,
        )
        self.maintenance = False  # the host requested the REPL and nothing prevents it

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
        self.outgoing.poll(stats)

    def _received(self):
        buf = self._decoder.buf
        kind = buf[messages.TYPE_AT]
        if kind == messages.HELLO.type_id:
            self._on_hello(buf)
        elif kind == messages.MAINTENANCE.type_id:
            self._on_maintenance(buf)
        elif not messages.COMMAND.type_id <= kind < messages.STATE.type_id:
            # Our own message, returned: it does not count as a host frame or for the sequence.
            self.incoming.refuse()
        elif self._in_order(buf):
            age_ms = (self._outbox.ticks - u16(buf, messages.STAMP_AT)) & 0xFFFF
            if age_ms <= limits.FRAME_STALE_MS:
                # Only a fresh frame shows that the host lives: a backlog may outlive it. And only
                # one newer than all before: a recording must not block the next ones.
                self._last_seq = buf[messages.SEQ_AT]
                self._heard_at = self._outbox.ticks
                back = self._inbox.back
                back.host_count = (back.host_count + 1) & 0xFFFF
            self._inbox.touch()
            if kind == messages.PING.type_id:
                self.outgoing.pong(buf)
            elif kind == messages.TELEMETRY.type_id and 1 <= buf[_PERIOD] <= 100:
                self._telemetry.period_ms = buf[_PERIOD]
            elif kind == messages.TRACE_REQUEST.type_id and buf[_ON] <= 1:
                self._trace.ask(buf[_ON] == 1)
            else:
                self.incoming.take(kind, buf, age_ms)

    def _silent_ms(self):
        return (self._outbox.ticks - self._heard_at) & 0x3FFFFFFF

    # Newer than the last one. A host whose frames got lost for so long that its next one looks old
    # ends its session by that silence.
    def _in_order(self, buf):
        if self._last_seq == _ANY_SEQ:
            return True  # no frame with this session's nonce has come before
        if not 1 <= (buf[messages.SEQ_AT] - self._last_seq) & 0xFF <= 127:
            self.incoming.late()
            return False
        return True

    def _on_hello(self, buf):
        if buf[_ROLE] != codes.ROLE_HOST:
            return
        session = u16(buf, _SESSION)
        for k in range(4):
            if buf[_SCHEMA + k] != self.outgoing.hello[_SCHEMA + k]:
                session = 0  # another version: answer, so that it can report it; no session
        self.outgoing.greet()
        if session == 0 or session == self._session:
            return
        self._draw_nonce(self._nonce)  # before the first frame of the session can be valid
        self._session = session
        self._keys.begin(session, self._boot, self._nonce, 0, self._outbox.ticks & 0xFFFF)
        self._last_seq = _ANY_SEQ  # the HELLO may be an old one, its seq, too
        self._heard_at = self._outbox.ticks
        self.outgoing.begin(session)
        self.incoming.begin()

    # The host's silence has disarmed the chair: its frames do not count any more, even if somebody
    # has recorded them. It must send a new hello.
    def _end_session(self):
        self._session = 0
        self._keys.end()
        self.outgoing.end_session()
        self.incoming.forget()

    def _on_maintenance(self, buf):
        for k in range(4):
            if buf[_KEY + k] != self.outgoing.maintenance_key[_KEY + k]:
                self.incoming.refuse()
                return
        if buf[_CLEARS] != codes.NO_REASON:
            # A caretaker's clear for a board that does not start, late: this one runs.
            self.incoming.refuse()
            return
        self.maintenance = self._safety.state == codes.DISARMED
        self.outgoing.answer_maintenance(self.maintenance)

    def answer_setting(self, value, refused):
        asked = self.incoming
        asked.setting_pending = False
        self.outgoing.answer_setting(asked.setting_request, asked.setting_index, value, refused)
