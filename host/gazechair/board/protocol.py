"""The host's side of the wire protocol. Pure: bytes and times in, bytes and events out; no I/O."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import Any

from gazechair.board.board_commands import STOP_COMMAND, Bypass, Clearance, Command
from gazechair.board.events import (
    Event,
    FaultText,
    Pong,
    SessionBegun,
    SessionEnded,
    SettingReply,
    VersionDiffers,
)
from gazechair.board.known_settings import KnownSettings
from gazechair.board.orders import Orders
from gazechair.board.relay import RelayQuestion
from gazechair.board.state import BoardId, BoardLimits, BoardState, BoardStats
from gazechair.board.zone import NOT_KNOWN, ReceivedZone
from gazelink import VERSION, codes, frame, messages

HELLO_PERIOD_S = 0.2
COMMAND_PERIOD_S = 0.02
CLEARANCE_PERIOD_S = 0.05
TRACE_PERIOD_S = 10.0  # after a lost frame nothing is known until the next snapshot
RESYNC_S = 1.0  # a session without a received frame for this long is restarted
_U16 = 65535
_NAME = b"gazechair"

# Gets each frame without its CRC: "up" or "down", when, its bytes.
Witness = Callable[[str, float, bytes], None]


def random_session() -> int:
    """A session id, 1..65535."""
    return secrets.randbelow(_U16) + 1


class LinkProtocol:
    """One board on one port. Not thread-safe: the owner locks. Times are monotonic seconds."""

    def __init__(
        self,
        draw_session: Callable[[], int] = random_session,
        witness: Witness = lambda _way, _now_s, _frame: None,
        traced: bool = False,
    ) -> None:
        """`draw_session` gives session ids; it is called again until one is new. `witness` sees
        every frame that is sent or accepted. `traced`: the board is to send its trace, for it."""
        self._draw_session = draw_session
        self.witness = witness
        self._decoder = frame.Decoder()
        self._encoder = frame.Encoder()
        self._session = 0
        self._keys = frame.Session()
        self._decoder.session = self._keys
        self._encoder.session = self._keys
        self._nonce = b""
        self._greeted: tuple[str, str, bool, int] | None = None  # echoes our HELLO
        self._board: BoardId | None = None
        self._stamp_ms = 0
        self._received_s = 0.0
        self._hello_due_s = 0.0
        self._command = STOP_COMMAND
        self._command_due_s = 0.0
        self._clearance: Clearance | None = None
        self._clearance_due_s = 0.0
        self._bypass: Bypass | None = None
        self._bypass_due_s = 0.0
        self._orders = Orders(secrets.randbelow(255) + 1)
        self._ping_token = secrets.randbelow(1 << 32)
        self._ping_wanted = False
        self._ping_sent_s: float | None = None
        self._setting: tuple[int, int, int] | None = None
        self._failure_reason = codes.NO_REASON  # of a board that does not start
        self._clears = False
        self._traced = traced
        self._trace_due_s = 0.0
        self._relay = RelayQuestion()
        self._known = KnownSettings()
        self._zone = ReceivedZone()

    @property
    def board(self) -> BoardId | None:
        """The board of the present session, or None while there is none."""
        return self._board

    @property
    def rx_corrupt(self) -> int:
        """Frames dropped for their stuffing, size or CRC, modulo 65536."""
        return int(self._decoder.corrupt)

    def opened(self, now_s: float) -> None:
        """A port was (re)opened: forget what came before and begin a handshake."""
        self._decoder = frame.Decoder()
        self._decoder.session = self._keys
        self._forget_failure()
        self._handshake(now_s)

    # Values to send

    def command(self, command: Command, now_s: float) -> None:
        """The latest command; a changed one is due at once, a refreshed one at its next repeat."""
        if not command.same_as(self._command):
            self._command_due_s = now_s
        self._command = command

    def clearance(self, clearance: Clearance, now_s: float) -> None:
        """The latest clearance, due at once."""
        self._clearance = clearance
        self._clearance_due_s = now_s

    def bypass(self, bypass: Bypass | None, now_s: float) -> None:
        """The caretaker's bypass button, due at once; None: released."""
        if bypass is None or self._bypass is None or bypass.number != self._bypass.number:
            self._bypass_due_s = now_s
        if bypass is not None or self._bypass is None:
            self._bypass = bypass
        else:
            self._bypass = Bypass(self._bypass.number, 0.0)  # sent once more: no time left

    def order(self, action: int, owner: int, now_s: float) -> None:
        """A new order (codes.ARM, ...), due at once and repeated; see orders."""
        if self._board is None and self._failure_reason and action == codes.RESET_FAULTS:
            self._clears = True
            self._hello_due_s = now_s
            return
        self._orders.give(action, owner, now_s)

    def request_ping(self) -> None:
        """Send one PING with the next poll."""
        self._ping_wanted = True

    def request_setting(self, request: int, index: int, value: int) -> None:
        """Send one SETTING with the next poll."""
        self._setting = (request, index, value)

    # Bytes out

    def poll(self, now_s: float) -> bytes:
        """The frames due now, most urgent first, at most one of each kind; b"" when none is."""
        if self._board is None:
            if now_s < self._hello_due_s:
                return b""
            self._hello_due_s = now_s + HELLO_PERIOD_S
            return self._clear(now_s) + self._hello(now_s)
        if now_s - self._received_s > RESYNC_S:
            return b""  # the caller learns of it from check()
        out = b""
        for order in self._orders.due(now_s):
            out += self._frame(now_s, messages.ORDER, (order.action, order.number, order.owner))
        if now_s >= self._command_due_s:
            self._command_due_s = now_s + COMMAND_PERIOD_S
            ttl_ms = self._board.limits.command_ttl_ms
            if self._command.mode == codes.AUTO:
                ttl_ms = self._board.limits.auto_ttl_ms
                watched = self._command.supervision(now_s)
                out += self._frame(now_s, messages.SUPERVISION, watched)
            out += self._frame(now_s, messages.COMMAND, self._command.fields(now_s, ttl_ms))
        if self._clearance is not None and now_s >= self._clearance_due_s:
            self._clearance_due_s = now_s + CLEARANCE_PERIOD_S
            out += self._frame(now_s, messages.CLEARANCE, self._clearance.fields(now_s))
        if self._bypass is not None and now_s >= self._bypass_due_s:
            self._bypass_due_s = now_s + CLEARANCE_PERIOD_S
            ttl_ms = self._board.limits.command_ttl_ms
            out += self._frame(now_s, messages.BYPASS, self._bypass.fields(now_s, ttl_ms))
            if now_s >= self._bypass.ttl_deadline_s:
                self._bypass = None
        if self._ping_wanted:
            self._ping_wanted = False
            self._ping_token = (self._ping_token + 1) & 0xFFFFFFFF
            self._ping_sent_s = now_s
            out += self._frame(
                now_s, messages.PING, (self._ping_token & _U16, self._ping_token >> 16)
            )
        # The board answers one at a time.
        setting = self._setting or self._relay.due(now_s) or self._known.due(now_s)
        if setting is not None:
            out += self._frame(now_s, messages.SETTING, setting)
            self._setting = None
        if self._traced and now_s >= self._trace_due_s:
            self._trace_due_s = now_s + TRACE_PERIOD_S
            out += self._frame(now_s, messages.TRACE_REQUEST, (1,))
        return out

    def check(self, now_s: float) -> list[Event]:
        """Events of time alone: restarts a session in which no frame arrives any more."""
        if self._board is None or now_s - self._received_s <= RESYNC_S:
            return []
        self._handshake(now_s)
        return [SessionEnded(f"the board has sent nothing for {RESYNC_S:.0f} s")]

    def due_s(self) -> float:
        """When to poll and check again at the latest."""
        if self._board is None:
            return self._hello_due_s
        due = min(self._command_due_s, self._orders.due_s())
        due = min(due, self._relay.due_s(), self._known.due_s())
        if self._bypass is not None:
            due = min(due, self._bypass_due_s)
        return due if self._clearance is None else min(due, self._clearance_due_s)

    def _clear(self, now_s: float) -> bytes:
        # A board that sends its last message has no session; frozen messages still reach it.
        if not self._clears:
            return b""
        values = (messages.MAINTENANCE_KEY, 0, self._failure_reason)
        self._forget_failure()
        return self._frame(now_s, messages.MAINTENANCE, values)

    def _forget_failure(self) -> None:
        self._failure_reason = codes.NO_REASON
        self._clears = False

    def _hello(self, now_s: float) -> bytes:
        values = (codes.ROLE_HOST, 0, frame.schema_hash(), self._session, 0, *VERSION, _NAME)
        return self._frame(now_s, messages.HELLO, values)

    def _frame(self, now_s: float, message: messages.Message, values: tuple[object, ...]) -> bytes:
        message.pack(self._encoder.body, values)
        size = self._encoder.finish(message, self._stamp_ms)
        self.witness("up", now_s, bytes(self._encoder.body[: message.size]))
        return bytes(self._encoder.wire[:size])

    # Bytes in

    def feed(self, data: bytes, now_s: float) -> list[Event]:
        """Take received bytes; what they meant, in order. Never raises on any bytes."""
        events: list[Event] = []
        for byte in data:
            if self._decoder.feed(byte):
                self._accept(now_s, events)
        return events

    def _accept(self, now_s: float, events: list[Event]) -> None:
        buf = self._decoder.buf
        message = messages.BY_TYPE[buf[messages.TYPE_AT]]
        if message.direction == messages.UP:
            return
        self.witness("down", now_s, bytes(buf[: message.size]))
        if message is messages.HELLO:
            self._hello_received(message.unpack(buf), now_s, events)
            return
        if message is messages.NONCE:
            self._nonce_received(message.unpack(buf), now_s, events)
            return
        if message is messages.FAULT:
            fields = message.unpack(buf)
            reason = str(codes.reason_name(fields["reason"]))
            if self._board is None:
                self._failure_reason = fields["reason"]
            events.append(FaultText(reason, _text(fields["detail"])))
            return
        if message is messages.LIMITS and self._board is None:
            self._limits_received(message.unpack(buf), now_s, events)
            return
        if self._board is None or message.plain:
            return
        self._received_s = now_s
        self._keys.advance(frame.u16(buf, messages.STAMP_AT))
        self._stamp_ms = self._keys.clock_ms
        if message is messages.STATE:
            events.append(self._state(message.unpack(buf), now_s))
        elif message is messages.STATS:
            events.append(BoardStats(message.unpack(buf), now_s))
        elif message is messages.SETTING_REPLY:
            reply = SettingReply(**message.unpack(buf))
            self._relay.received(reply.index, reply.value, reply.refused)
            self._known.received(reply, now_s)
            events.append(reply)
            if reply.request != codes.SETTING_GET and not reply.refused:
                self._zone.forget()  # the board sends it again, right after this
                events.append(NOT_KNOWN)
        elif message is messages.ZONE:
            zone = self._zone.received(**message.unpack(buf))
            if zone is not None:
                events.append(zone)
        elif message is messages.PONG:
            fields = message.unpack(buf)
            token = fields["token_low"] | fields["token_high"] << 16
            if token == self._ping_token and self._ping_sent_s is not None:
                events.append(Pong(now_s - self._ping_sent_s))
                self._ping_sent_s = None

    def _hello_received(self, fields: dict[str, int], now_s: float, events: list[Event]) -> None:
        if fields["role"] != codes.ROLE_BOARD:
            return  # our own message, echoed by a foreign device
        name = _text(fields["name"])
        version = f"{fields['major']}.{fields['minor']}.{fields['patch']}"
        if fields["schema_hash"] != frame.schema_hash():
            if self._board is not None:
                self._handshake(now_s)
                events.append(SessionEnded("the board came back with another version"))
            own = ".".join(str(part) for part in VERSION)
            events.append(
                VersionDiffers(
                    f"the board ({name or 'unnamed'}) runs version {version} and this host {own},"
                    " which do not fit together; flash the board with this version"
                )
            )
            return
        if self._board is not None:
            if (fields["session"], fields["boot"]) != (self._session, self._board.boot):
                self._handshake(now_s)
                events.append(SessionEnded("the board has restarted"))
            return
        if fields["session"] != self._session:
            return  # not yet an answer to our HELLO
        simulated = bool(fields["flags"] & codes.FLAG_SIMULATED)
        self._greeted = (name, version, simulated, fields["boot"])

    def _nonce_received(self, fields: dict[str, Any], now_s: float, events: list[Event]) -> None:
        if fields["session"] != self._session:
            return
        if self._board is not None:
            if fields["nonce"] != self._nonce:
                self._handshake(now_s)
                events.append(SessionEnded("the board has restarted the session"))
            return
        if self._greeted is None:
            return
        self._nonce = fields["nonce"]
        stamp_ms = frame.u16(self._decoder.buf, messages.STAMP_AT)
        self._keys.begin(self._session, self._greeted[-1], self._nonce, fields["epoch"], stamp_ms)

    def _limits_received(self, fields: dict[str, int], now_s: float, events: list[Event]) -> None:
        # The session begins here, so that nothing is sent by any limits but this board's own.
        assert self._greeted is not None  # the frame is of this session
        self._forget_failure()
        self._board = BoardId(*self._greeted, self._session, BoardLimits(**fields))
        self._keys.advance(frame.u16(self._decoder.buf, messages.STAMP_AT))
        self._stamp_ms = self._keys.clock_ms
        self._received_s = now_s
        self._command_due_s = now_s
        self._clearance_due_s = now_s
        self._trace_due_s = now_s
        self._relay.begin(now_s)
        self._known.forget()
        self._zone.forget()
        self._orders.begin()
        events.append(SessionBegun(self._board))

    def _state(self, fields: dict[str, int], now_s: float) -> BoardState:
        disarmed = fields["status"] & 15 == codes.DISARMED
        self._orders.board_seen(disarmed, bool(fields["faults"] & (1 << codes.EMERGENCY)))
        return BoardState(
            state=fields["status"] & 15,
            motion=fields["status"] >> 4,
            override=fields["override"],
            arm_reason=fields["arm_reason"],
            first_fault=fields["first_fault"],
            faults=fields["faults"],
            heading_deg=fields["heading_q4_deg"] / 16,
            linear_permille=fields["linear_permille"],
            turn_permille=fields["turn_permille"],
            edge=fields["edge"],
            decisions=fields["decisions"],
            board_ms=self._stamp_ms,
            received_s=now_s,
            relay_checked=self._relay.checked(now_s),
            settings=self._known.values,
        )

    def _handshake(self, now_s: float) -> None:
        # A new session, unlike the last, so that no frame of the last one counts any more.
        old = self._session
        while self._session in (0, old):
            self._session = self._draw_session()
        self._board = None
        self._greeted = None
        self._keys.end()
        self._ping_sent_s = None
        self._hello_due_s = now_s


def _text(field: object) -> str:
    assert isinstance(field, bytes)
    return field.split(b"\0")[0].decode("ascii", "replace")
