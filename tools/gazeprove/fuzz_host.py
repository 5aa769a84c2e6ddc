"""The fuzzer's end of the line: honest frames with their birth times, and frames nobody meant.

Independent of the firmware's reading of them: what a frame is worth is written beside its bytes.
"""

from __future__ import annotations

import random
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from gazelink import arcs, codes, frame, messages
from gazeprove.fuzz_board import World

HONEST = ""
HELLO_EVERY_US = 200_000
_RECORDED = 600
_FAR: dict[str, Any] = {
    **{n: messages.CLEAR_FAR for n in messages.CLEARANCE.names if n.endswith(("_mm", "_deg"))},
    "arcs": arcs.ALL_FAR,
}
_BLANK: dict[str, dict[str, Any]] = {
    message.name: {
        name: b"" if letter.endswith("s") else 0
        for name, letter in (field.split(":") for field in message.fields.split())
    }
    for message in messages.MESSAGES
}


@dataclass(eq=False)
class Sent:
    """One frame on its way. `spoilt`: why it must count for nothing; "" is an honest frame."""

    message: messages.Message
    fields: dict[str, Any]
    born_us: int
    index: int  # honest frames count up in the order they were born
    session: object  # the life of host and board it was made for
    press: int = 0  # of a command: counts up with each new press
    spoilt: str = HONEST

    def __str__(self) -> str:
        named = " ".join(f"{k}={v}" for k, v in self.fields.items() if v)
        kind = f"{self.spoilt} " if self.spoilt else ""
        return f"{kind}{self.message.name} press={self.press} {named}"


@dataclass
class Held:
    """What the host repeats: a press and how its time to live runs."""

    verb: int = codes.STOP
    mode: int = 0
    edge: int = 0
    owner: int = codes.DRIVER
    linear: int = 0
    turn: int = 0
    cap: int = 1000
    pulse_ms: int = 0
    press: int = 0
    until_us: int = 0  # the last proof of holding ends then, unless `refreshed`
    refreshed: bool = False
    ttl_ms: int = 300


@dataclass
class View:
    """What the lidars see, as CLEARANCE's fields; `at_us` the acquisition when it stands still."""

    fields: dict[str, Any] = field(default_factory=dict)
    age_ms: int = 5
    frozen_at_us: int = -1


class Host:
    """Builds frames, keeps time, remembers what it sent. One session after another."""

    def __init__(self, world: World, rng: random.Random) -> None:
        self._world = world
        self._rng = rng
        self._encoder = frame.Encoder()
        self._keys = frame.Session()
        self._encoder.session = self._keys
        self._queue: list[tuple[int, bytes, Sent]] = []
        self._index = 0
        self._session = 0
        self._edge = rng.randrange(255)
        self._presses = 0
        self._order_number = rng.randrange(255)
        self.session_key: object = None
        self.stamp = 0
        self.boot = 0
        self.nonce = bytes(4)
        self._greeted = False
        self.recorded: list[tuple[int, bytes, Sent]] = []
        self.alive = True
        self.stalled = False  # what is sent waits, and then comes all at once
        self.delay_us = 0
        self.command_every_us = 20_000
        self.clearance_every_us = 50_000
        self._due = [0, 0, 0, 0]
        self.held = Held()
        self.says_command = True
        self.watched_us = -1  # when somebody was last seen to watch; -1: now
        self.view: View | None = View()
        self.bypass = 0
        self._order: dict[str, int] | None = None
        self._order_until_us = 0
        self.new_session()

    # -- what is said --------------------------------------------------------------------------

    def new_session(self) -> None:
        """Forget the board; the next HELLO begins anew."""
        old = self._session
        while self._session in (0, old):
            self._session = self._rng.randrange(1, 65536)
        self.session_key = None
        self._greeted = False
        self._keys.end()
        self._due[0] = 0

    def press(self, verb: int, mode: int, owner: int = codes.DRIVER, **more: int) -> Held:
        """A new press, repeated and refreshed until something else is held."""
        self._edge = self._edge % 255 + 1
        self._presses += 1
        self.held = Held(verb, mode, self._edge, owner, press=self._presses, refreshed=True)
        for name, value in more.items():
            setattr(self.held, name, value)
        self._due[1] = 0
        return self.held

    def let_go(self) -> None:
        """STOP from now on."""
        self.held = Held(owner=self.held.owner)
        self._due[1] = 0

    def order(self, action: int, owner: int, times: int = 1) -> None:
        """A new order, sent at once, `times` in a row, and repeated for 200 ms."""
        self._order_number = self._order_number % 255 + 1
        fields = {"action": action, "number": self._order_number, "owner": owner}
        self._order = fields
        self._order_until_us = self._world.now_us + 200_000
        self._due[3] = self._world.now_us + 20_000
        for _ in range(times):
            self.send(messages.ORDER, **fields)

    def forget_order(self) -> None:
        """Do not repeat the last one."""
        self._order = None

    def step(self) -> None:
        """What is due now; then what has arrived goes to the board."""
        now = self._world.now_us
        due = self._due
        if self.alive:
            if self.session_key is None:
                if now >= due[0]:
                    due[0] = now + HELLO_EVERY_US
                    self.hello(self._session)
            else:
                if self._order is not None and now >= due[3]:
                    due[3] = now + 20_000
                    if now > self._order_until_us:
                        self._order = None
                    else:
                        self.send(messages.ORDER, **self._order)
                if now >= due[1]:
                    due[1] = now + self.command_every_us
                    if self.says_command:
                        self.say_command()
                if now >= due[2]:
                    due[2] = now + self.clearance_every_us
                    if self.view is not None:
                        self.say_clearance(self.view)
                    if self.bypass:
                        self.send(messages.BYPASS, number=self.bypass, ttl_ms=300)
        if self._queue and not self.stalled:
            self.deliver(now)

    def deliver(self, now: int) -> None:
        """Frames whose time has come reach the board in their order."""
        later = []
        for item in self._queue:
            if item[0] <= now:
                self._world.serial.push(item[1], item[2])
            else:
                later.append(item)
        self._queue = later

    def hello(self, session: int) -> None:
        """Say HELLO."""
        values = {"schema_hash": frame.schema_hash(), "session": session, "major": 1, "name": b"f"}
        self.send(messages.HELLO, **values)

    def say_command(self) -> None:
        """The held press as it stands now."""
        held = self.held
        now = self._world.now_us
        if held.mode == codes.AUTO:
            age_ms = 0 if self.watched_us < 0 else min(65535, (now - self.watched_us) // 1000)
            self.send(messages.SUPERVISION, edge=held.edge, owner=codes.DRIVER, age_ms=age_ms)
        if held.refreshed:
            held.until_us = now + held.ttl_ms * 1000
        self.send_command(held, max(0, held.until_us - now) // 1000)

    def send_command(self, held: Held, ttl_ms: int) -> Sent:
        """One COMMAND of this press."""
        return self.send(
            messages.COMMAND,
            held.press,
            verb=held.verb,
            mode=held.mode,
            edge=held.edge,
            owner=held.owner,
            ttl_ms=ttl_ms,
            linear_permille=held.linear,
            turn_permille=held.turn,
            cap_permille=held.cap,
            pulse_ms=held.pulse_ms,
        )

    def say_clearance(self, view: View) -> None:
        """What is seen, with its age."""
        now = self._world.now_us
        age_ms = view.age_ms
        if view.frozen_at_us >= 0:
            age_ms = min(65535, (now - view.frozen_at_us) // 1000)
        self.send(messages.CLEARANCE, **{**_FAR, **view.fields, "age_ms": age_ms})

    def send(self, message: messages.Message, press: int = 0, **fields: Any) -> Sent:
        """An honest frame, on its way after the line's delay."""
        self._index += 1
        now = self._world.now_us
        fields = {**_BLANK[message.name], **fields}
        sent = Sent(message, fields, now, self._index, self.session_key, press)
        data = self._bytes(message, fields)
        self._queue.append((now + self.delay_us, data, sent))
        self.recorded.append((now, data, sent))
        if len(self.recorded) > _RECORDED:
            del self.recorded[: _RECORDED // 2]
        return sent

    def _bytes(self, message: messages.Message, fields: dict[str, Any]) -> bytes:
        encoder = self._encoder
        if not message.plain and (encoder.session is None or not encoder.session.live):
            return b""
        message.pack(encoder.body, list(fields.values()))
        return bytes(encoder.wire[: encoder.finish(message, self.stamp)])

    # -- what nobody meant ---------------------------------------------------------------------

    def inject(self, data: bytes, like: Sent, why: str) -> None:
        """Bytes on the line right now that must count for nothing."""
        sent = Sent(like.message, like.fields, like.born_us, like.index, like.session, like.press)
        sent.spoilt = why
        self._world.serial.push(data, sent)

    def foreign(
        self, message: messages.Message, keys: frame.Session, why: str, **fields: Any
    ) -> None:
        """A fresh frame with another seed, in sequence."""
        fields = {**_BLANK[message.name], **fields}
        self._encoder.session = keys
        data = self._bytes(message, fields)
        self._encoder.session = self._keys
        sent = Sent(message, fields, self._world.now_us, 0, None)
        self.inject(data, sent, why)

    def keys_of_others(self) -> list[tuple[frame.Session, str]]:
        """Of other sessions, boots, nonces and rounds of the stamp."""
        session, boot, nonce, epoch = self._session, self.boot, self.nonce, self._keys.epoch
        other = bytes([nonce[0] ^ 1, *nonce[1:]])
        found = []
        for ids, why in (
            ((session ^ 1, boot, nonce, epoch), "foreign session"),
            ((session, boot ^ 1, nonce, epoch), "foreign boot"),
            ((session, boot, other, epoch), "foreign nonce"),
            ((session, boot, nonce, epoch + 1), "another round of the stamp"),
        ):
            keys = frame.Session()
            keys.begin(*ids, self.stamp)
            found.append((keys, why))
        return found

    # -- what is received ----------------------------------------------------------------------

    def received(self, kind: int, stamp: int, fields: dict[str, Any]) -> bool:
        """A frame of the board's; True when a session began."""
        if kind == messages.HELLO.type_id:
            if self.session_key is not None:
                if (fields["session"], fields["boot"]) != (self._session, self.boot):
                    self.new_session()
                return False
            self._greeted = fields["session"] == self._session
            self.boot = fields["boot"]
            return False
        if kind == messages.NONCE.type_id:
            if fields["session"] != self._session or not self._greeted:
                return False
            if self.session_key is not None:
                if fields["nonce"] != self.nonce:
                    self.new_session()
                return False
            self.stamp = stamp
            self.nonce = fields["nonce"]
            self._keys.begin(self._session, self.boot, self.nonce, fields["epoch"], stamp)
            self.session_key = (self._session, self.boot)
            return True
        self._keys.advance(stamp)
        self.stamp = stamp
        return False

    def seed(self, stamp: int) -> bytes | None:
        """Of the session's frames with that stamp."""
        seed: bytes | None = self._keys.seed(stamp)
        return seed

    @property
    def session(self) -> int:
        """The session's number."""
        return self._session


class Reader:
    """Reads the board's frames: COBS and CRC once more, with nothing of the firmware's."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self.broken = 0

    def take(
        self, data: bytearray, seed: Callable[[int], bytes | None]
    ) -> list[tuple[int, int, dict[str, Any]]]:
        """(type, stamp, fields) of each whole frame in `data` and what was left before."""
        self._rest += data
        found: list[tuple[int, int, dict[str, Any]]] = []
        while True:
            end = self._rest.find(0)
            if end < 0:
                return found
            body = _unstuffed(bytes(self._rest[:end]))
            del self._rest[: end + 1]
            message = messages.BY_TYPE.get(body[0]) if len(body) > 8 else None
            start = 0
            if message is not None and not message.plain:
                start = int.from_bytes(seed(body[2] | body[3] << 8) or b"", "little")
            if message is None or len(body) != message.size + 4 or not _checks(body, start):
                self.broken += 1
                continue
            stamp = body[2] | body[3] << 8
            values = struct.unpack_from(message.format, body, 4)
            found.append((body[0], stamp, dict(zip(message.names, values, strict=True))))

    def forget(self) -> None:
        """The line was cut."""
        self._rest.clear()


def _unstuffed(data: bytes) -> bytes:
    out = bytearray()
    at = 0
    while at < len(data):
        code = data[at]
        out += data[at + 1 : at + code]
        at += code
        if at < len(data):
            out.append(0)
    return bytes(out)


def _checks(body: bytes, start: int) -> bool:
    return zlib.crc32(body[:-4], start) == int.from_bytes(body[-4:], "little")
