"""The control sockets: messages from a page go straight to the driver port, states go back."""

from __future__ import annotations

import contextlib
import json
import logging
import threading
import time
from dataclasses import dataclass
from typing import Any

from gazechair.driver_port import DriverPort, Message
from gazechair.web.limits import RateLimit
from gazechair.web.sockets import (
    CLOSE_GOING_AWAY,
    CLOSE_POLICY,
    CLOSE_TRY_LATER,
    GONE,
    hang_up,
    prepare,
)

MAX_CLIENTS = 8
MAX_MESSAGE = 256
MESSAGES_PER_S = 100
_FLOOD_PER_S = 1000
STATE_PERIOD_S = 0.1
TOKEN_PERIOD_S = 0.05
_COALESCE_S = 0.02  # several changes at once become one state
_REFUSAL_PERIOD_S = 0.2
_LOOK_S = 0.2
_SILENT_S = 10.0  # a page sends a heartbeat every 100 ms; hidden ones once a second
# Never refused for coming too fast.
_ALWAYS = ("stop", "emergency", "disarm")

log = logging.getLogger(__name__)


def refused(what: str, reason: str, detail: str) -> Message:
    """The {"k": "refused"} object of the page protocol."""
    return {"k": "refused", "what": what, "reason": reason, "detail": detail}


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


class ControlHub:
    """All control sockets of one server, and the thread that watches for changes."""

    def __init__(self, port: DriverPort) -> None:
        self._port = port
        self._lock = threading.Condition()
        self._clients: set[_Client] = set()
        self._stopping = threading.Event()
        self._watcher = threading.Thread(target=self._watch, name="web-watch", daemon=True)

    def start(self) -> None:
        """Start watching for changes."""
        self._watcher.start()

    def stop(self) -> None:
        """Cut every socket (which stops what it commanded) and end the thread."""
        self._stopping.set()
        with self._lock:
            for client in self._clients:
                client.cut()
            self._lock.wait_for(lambda: not self._clients, 3.0)
        if self._watcher.is_alive():
            self._watcher.join(2.0)

    def serve(self, ws: Any, peer: str) -> None:
        """Serve one page until its socket ends; runs on the request's own thread."""
        prepare(ws)
        with self._lock:
            full = len(self._clients) >= MAX_CLIENTS or self._stopping.is_set()
            client = None if full else _Client(ws, self._port)
            if client is not None:
                self._clients.add(client)
        if client is None:
            log.warning("refused page %s: %d are connected already", peer, MAX_CLIENTS)
            with contextlib.suppress(*GONE):
                ws.close(CLOSE_TRY_LATER, f"at most {MAX_CLIENTS} pages at once")
            return
        log.info("page %s connected as client %d", peer, client.id)
        ending = _Ending(None, "its socket closed")
        try:
            ending = client.run()
        except GONE:
            pass
        finally:
            # First of all: what it commanded stops.
            self._port.disconnect(client.id)
            client.end(ending)
            with self._lock:
                self._clients.discard(client)
                self._lock.notify_all()
            log.info("page %s, client %d, gone: %s", peer, client.id, ending.why)

    def _watch(self) -> None:
        version = 0
        while not self._stopping.is_set():
            now = self._port.wait_change(_LOOK_S, version)
            if now != version:
                version = now
                with self._lock:
                    clients = list(self._clients)
                for client in clients:
                    client.changed()


@dataclass(frozen=True)
class _Ending:
    """Why a client ends, and the code that tells its page (None: the socket is closed already)."""

    code: int | None
    why: str


class _Client:
    """One page: the request's thread receives, one more thread does all the sending."""

    def __init__(self, ws: Any, port: DriverPort) -> None:
        self._ws = ws
        self._port = port
        self.id = port.connect("driver")
        self._rate = RateLimit(MESSAGES_PER_S, MESSAGES_PER_S)
        self._flood = RateLimit(_FLOOD_PER_S, _FLOOD_PER_S)
        self._wake = threading.Condition()
        self._dirty = True
        self._ended = False
        self._refusals: dict[str, Message] = {}  # newest per kind of message
        self._sender = threading.Thread(
            target=self._send_all, name=f"web-control-{self.id}", daemon=True
        )

    def run(self) -> _Ending:
        """Receive until the client must end. Raises one of GONE when its socket ended."""
        self._sender.start()
        heard_s = time.monotonic()
        while True:
            raw = self._ws.receive(_LOOK_S)
            now_s = time.monotonic()
            if raw is not None:
                heard_s = now_s
                if not self._flood.allow(now_s):
                    return _Ending(CLOSE_POLICY, "far too many messages")
                self._handle(raw, now_s)
            elif now_s - heard_s > _SILENT_S or not self._ws.thread.is_alive():
                return _Ending(CLOSE_GOING_AWAY, "no heartbeat")

    def changed(self) -> None:
        """Send the state soon."""
        with self._wake:
            self._dirty = True
            self._wake.notify()

    def cut(self) -> None:
        """Break the connection from another thread."""
        hang_up(self._ws)

    def end(self, ending: _Ending) -> None:
        """Close the socket and end the sending thread."""
        with self._wake:
            self._ended = True
            self._wake.notify()
        if ending.code is not None:
            with contextlib.suppress(*GONE):
                self._ws.close(ending.code, ending.why)
        hang_up(self._ws)
        self._sender.join(2.0)

    def _handle(self, raw: object, now_s: float) -> None:
        message = decode(raw)
        allowed = self._rate.allow(now_s)
        if isinstance(message, str):
            self._refuse(refused("message", "bad_message", message))
        elif allowed or message["k"] in _ALWAYS:
            for reply in self._port.receive(self.id, message):
                self._refuse(reply)
        else:
            detail = f"more than {MESSAGES_PER_S} messages a second"
            self._refuse(refused("message", "too_fast", detail))

    def _refuse(self, reply: Message) -> None:
        with self._wake:
            self._refusals[str(reply.get("what"))] = reply
            self._wake.notify()

    def _send_all(self) -> None:
        try:
            self._send(self._port.welcome(self.id))
            token_s = state_s = refusal_s = -1.0
            while True:
                with self._wake:
                    now_s = time.monotonic()
                    state_due_s = state_s + (_COALESCE_S if self._dirty else STATE_PERIOD_S)
                    due_s = min(state_due_s, token_s + TOKEN_PERIOD_S)
                    if self._refusals:
                        due_s = min(due_s, refusal_s + _REFUSAL_PERIOD_S)
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
                    self._send(self._port.snapshot(self.id))
                elif send_token:
                    self._send({"k": "token", "token": self._port.token()})
        except GONE:
            hang_up(self._ws)  # the receiving side ends the client

    def _send(self, message: Message) -> None:
        self._ws.send(json.dumps(message, separators=(",", ":")))
