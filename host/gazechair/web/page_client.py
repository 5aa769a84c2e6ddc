"""One page on a control socket: passes its messages to the driver port, and states back."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from dataclasses import dataclass

from gazechair.base.rate_limit import RateLimit
from gazechair.driving.driver_port import DriverPort, Message
from gazechair.driving.refusal import Refusal
from gazechair.people.pairing import Device
from gazechair.web.websocket import CLOSE_GOING_AWAY, WebSocket

MAX_MESSAGE = 256
MESSAGES_PER_S = 100
STATE_PERIOD_S = 0.1
TOKEN_PERIOD_S = 0.05
_COALESCE_S = 0.02  # several changes at once become one state
_REFUSAL_PERIOD_S = 0.2
_LOOK_S = 0.2
_FAREWELL_S = 1.0
_SILENT_S = 10.0  # a page sends a heartbeat every 100 ms; hidden ones once a second
# Never refused for coming too fast.
_ALWAYS = ("stop", "emergency", "disarm")


def decode(raw: object) -> Message | str:
    """A page's message as an object with a text "k", or one plain line on what is wrong with it."""
    if not isinstance(raw, str):
        return "binary message: send JSON text"
    if len(raw.encode("utf-8", "surrogatepass")) > MAX_MESSAGE:
        return f"message of more than {MAX_MESSAGE} bytes"
    try:
        message = json.loads(raw, parse_constant=_no_constant)
    except ValueError as error:
        return f"not JSON: {error}"
    if not isinstance(message, dict):
        return 'not an object: send {"k": ...}'
    if not isinstance(message.get("k"), str):
        return 'no text "k" in the message'
    return message


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number")


@dataclass(frozen=True)
class Ending:
    """Why a client ends, and the close code for its page (None: the socket is closed already)."""

    code: int | None
    why: str


class PageClient:
    """One page: the request's thread receives, one more thread does all the sending."""

    def __init__(self, ws: WebSocket, port: DriverPort, device: Device, insecure: bool) -> None:
        """`insecure`: other machines can reach the host without encryption."""
        self._ws = ws
        self._port = port
        self._insecure = insecure
        self.device = device
        self.id = port.connect(device.role)
        self.received_s = time.monotonic()
        """When the page last sent anything."""
        self._rate = RateLimit(MESSAGES_PER_S, MESSAGES_PER_S)
        self._wake = threading.Condition()
        self._dirty = True
        self._ended = False
        self._dismissed: Ending | None = None
        self._refusals: dict[str, Message] = {}  # newest per kind of message
        self._sender = threading.Thread(
            target=self._send_all, name=f"web-control-{self.id}", daemon=True
        )

    def run(self) -> Ending:
        """Receive until the client must end. Raises OSError when its socket ended."""
        self._sender.start()
        while True:
            raw = self._ws.receive(_LOOK_S)
            now_s = time.monotonic()
            if self._dismissed is not None:
                return self._dismissed
            if raw is not None:
                self.received_s = now_s
                self._handle(raw, now_s)
            elif now_s - self.received_s > _SILENT_S:
                return Ending(CLOSE_GOING_AWAY, "no heartbeat")

    @property
    def dismissed(self) -> bool:
        """True if it has already been dismissed."""
        return self._dismissed is not None

    @property
    def drives(self) -> bool:
        """True if its page owns the chair."""
        return bool(self._port.snapshot(self.id).get("you", False))

    def changed(self) -> None:
        """Send the state soon."""
        with self._wake:
            self._dirty = True
            self._wake.notify()

    def dismiss(self, ending: Ending) -> None:
        """Disconnect the page, from another thread: its messages no longer count."""
        self._port.disconnect(self.id)
        with self._wake:
            self._dismissed = ending
            self._wake.notify()

    def cut(self) -> None:
        """Break the connection from another thread."""
        self._ws.hang_up()

    def end(self, ending: Ending) -> None:
        """Close the socket and end the sending thread."""
        with self._wake:
            self._ended = True
            self._wake.notify()
        if self._dismissed is not None:
            self._sender.join(_FAREWELL_S)  # it sends the reason, unless the reader is stuck
        else:
            with contextlib.suppress(OSError):
                self._farewell(ending)
        self._ws.hang_up()
        self._sender.join(2.0)

    def _handle(self, raw: object, now_s: float) -> None:
        message = decode(raw)
        allowed = self._rate.allow(now_s)
        if isinstance(message, str):
            self._refuse(Refusal("message", "bad_message", message).message())
        elif allowed or message["k"] in _ALWAYS:
            for reply in self._port.receive(self.id, message):
                self._refuse(reply)
        else:
            detail = f"more than {MESSAGES_PER_S} messages a second"
            self._refuse(Refusal("message", "too_fast", detail).message())

    def _refuse(self, reply: Message) -> None:
        with self._wake:
            self._refusals[str(reply.get("what"))] = reply
            self._wake.notify()

    def _send_all(self) -> None:
        try:
            welcome = self._welcome({})
            token_s = state_s = refusal_s = -1.0
            while True:
                with self._wake:
                    now_s = time.monotonic()
                    state_due_s = state_s + (_COALESCE_S if self._dirty else STATE_PERIOD_S)
                    due_s = min(state_due_s, token_s + TOKEN_PERIOD_S)
                    if self._refusals:
                        due_s = min(due_s, refusal_s + _REFUSAL_PERIOD_S)
                    if self._dismissed is not None:
                        break
                    if not self._ended and now_s < due_s:
                        self._wake.wait(due_s - now_s)
                        continue
                    if self._ended:
                        return
                    refusals: list[Message] = []
                    if self._refusals and now_s >= refusal_s + _REFUSAL_PERIOD_S:
                        refusals = list(self._refusals.values())
                        self._refusals.clear()
                        refusal_s = now_s
                    send_state = now_s >= state_due_s
                    if send_state:
                        self._dirty = False
                        state_s = now_s
                    send_token = send_state or now_s >= token_s + TOKEN_PERIOD_S
                    if send_token:
                        token_s = now_s
                for reply in refusals:
                    self._send(reply)
                if send_state:
                    welcome = self._welcome(welcome)
                    self._send(self._port.snapshot(self.id))
                elif send_token:
                    self._send({"k": "token", "token": self._port.token()})
            self._farewell(self._dismissed)
            self._ws.hang_up()  # wakes the receiving side, which ends the client
        except OSError:
            self._ws.hang_up()  # the receiving side ends the client

    def _welcome(self, last: Message) -> Message:
        # Send the page's welcome when it differs from the last one sent; return it.
        welcome = self._port.welcome(self.id)
        if welcome != last:
            self._send({**welcome, "name": self.device.name, "insecure": self._insecure})
        return welcome

    def _farewell(self, ending: Ending) -> None:
        if ending.code is not None:
            self._ws.close(ending.code, ending.why)

    def _send(self, message: Message) -> None:
        self._ws.send(json.dumps(message, separators=(",", ":")))
