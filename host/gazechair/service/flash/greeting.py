"""Contacts a running firmware with the frozen messages that every version understands."""

from __future__ import annotations

import select
import time
from dataclasses import dataclass
from typing import Any

from gazechair.board.serial_port import PortError, SerialPort
from gazechair.service.flash.errors import FlashError
from gazelink import VERSION, codes, frame, messages

_LISTEN_S = 0.6  # a firmware without a session sends its hello five times a second
_ASK_S = 0.25
_HELLO_S = 3.0
_RETRY_S = 0.2


@dataclass(frozen=True)
class Hello:
    """A running firmware's description of itself."""

    name: str
    version: str
    schema_hash: int
    simulated: bool
    armed: bool
    boot: int

    @property
    def ours(self) -> bool:
        """Whether it is the version that belongs to this gazechair."""
        return self.schema_hash == frame.schema_hash() and self.version == our_version()


def our_version() -> str:
    """Version of this gazechair and its firmware."""
    return ".".join(map(str, VERSION))


class Greeter:
    """Owns the port until `close`. Sends frozen frames only, and begins no session."""

    def __init__(self, path: str) -> None:
        """Raises FlashError when `path` cannot be opened."""
        try:
            self._port = SerialPort(path)
        except PortError as error:
            raise FlashError(str(error)) from None
        self._decoder = frame.Decoder()
        self._encoder = frame.Encoder()
        self.fault = ""  # the last message of a board that stopped, if it sent one

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def hello(self, timeout_s: float) -> Hello | None:
        """The firmware's description of itself; None when none answers in time.

        Raises FlashError when the port vanishes.
        """
        values = (codes.ROLE_HOST, 0, frame.schema_hash(), 0, 0, *VERSION, b"gazechair flash")
        answer = self._ask(messages.HELLO, values, timeout_s, listen_s=_LISTEN_S)
        if answer is None:
            return None
        return Hello(
            answer["name"].rstrip(b"\0").decode("ascii", "replace"),
            f"{answer['major']}.{answer['minor']}.{answer['patch']}",
            answer["schema_hash"],
            bool(answer["flags"] & codes.FLAG_SIMULATED),
            bool(answer["flags"] & codes.FLAG_ARMED),
            answer["boot"],
        )

    def enter_maintenance(self, timeout_s: float) -> None:
        """Request that the firmware exits to the REPL. Raises FlashError with its refusal."""
        values = (messages.MAINTENANCE_KEY, 0, 0)
        answer = self._ask(messages.MAINTENANCE, values, timeout_s, listen_s=0.0)
        if answer is None:
            raise FlashError(
                f"the firmware at {self._port.path} does not answer to maintenance; unplug it,"
                " plug it in again and repeat"
            )
        if not answer["accepted"]:
            reason = codes.reason_name(answer["reason"])
            raise FlashError(
                f"the board at {self._port.path} refuses maintenance ({reason}); disarm it first"
            )

    def _ask(
        self, message: Any, values: tuple[Any, ...], timeout_s: float, listen_s: float
    ) -> dict[str, Any] | None:
        start_s = now_s = time.monotonic()
        ask_s = start_s + listen_s
        while now_s < start_s + timeout_s:
            try:
                if now_s >= ask_s:
                    ask_s = now_s + _ASK_S
                    message.pack(self._encoder.body, values)
                    n = self._encoder.finish(message, 0)
                    self._port.write(bytes(self._encoder.wire[:n]))
                if select.select([self._port.fileno()], [], [], 0.05)[0]:
                    answer = self._listen(message)
                    if answer is not None:
                        return answer
            except PortError as error:
                raise FlashError(str(error)) from None
            now_s = time.monotonic()
        return None

    def _listen(self, wanted: Any) -> dict[str, Any] | None:
        data = self._port.read()
        if not data:
            time.sleep(0.02)  # a port that hung up is always ready
        answer: dict[str, Any] | None = None
        for byte in data:
            if not self._decoder.feed(byte):
                continue
            buf = self._decoder.buf
            kind = buf[messages.TYPE_AT]
            if kind == messages.FAULT.type_id:
                detail = messages.FAULT.unpack(buf)["detail"]
                self.fault = detail.rstrip(b"\0").decode("ascii", "replace")
            elif kind == wanted.type_id:
                fields = wanted.unpack(buf)
                if kind != messages.HELLO.type_id or fields["role"] == codes.ROLE_BOARD:
                    answer = fields
        return answer


def wait_for_hello(path: str, limit_s: float) -> tuple[Hello | None, str]:
    """After a reset: the firmware's hello, or None and what is wrong after `limit_s`.

    The port may vanish and reappear: every failure until then is retried.
    """
    trouble = "it says nothing"
    end_s = time.monotonic() + limit_s
    while time.monotonic() < end_s:
        try:
            greeter = Greeter(path)
        except FlashError as error:
            trouble = str(error)
            time.sleep(_RETRY_S)
            continue
        try:
            hello = greeter.hello(_HELLO_S)
            if hello is not None:
                return hello, ""
            trouble = greeter.fault or "it says nothing"
        except FlashError as error:
            trouble = str(error)
        finally:
            greeter.close()
        time.sleep(_RETRY_S)
    return None, trouble
