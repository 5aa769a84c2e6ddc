"""DriverPort: the interface of the host for the pages' server."""

from __future__ import annotations

from typing import Any, Protocol

Message = dict[str, Any]


class DriverPort(Protocol):
    """Callable from any thread; every method but wait_change returns in under a millisecond."""

    def connect(self, role: str) -> int:
        """Register a page of `role` (driver, caretaker, viewer); returns its client id, from 1."""
        ...

    def disconnect(self, client: int) -> None:
        """The page's socket has closed: its command stops at once. Unknown ids are ignored."""
        ...

    def welcome(self, client: int) -> Message:
        """The {"k": "welcome", ...} object: begins a connection, sent again when it changes."""
        ...

    def receive(self, client: int, message: Message) -> list[Message]:
        """Act on one decoded message from the page; returns the replies (refusals), mostly none.

        Never raises on bad content: a wrong key, type or range is answered by
        {"k": "refused", "what": ..., "reason": ..., "detail": ...} and nothing moves.
        """
        ...

    def snapshot(self, client: int) -> Message:
        """The {"k": "state", ...} object for this page now, with a fresh token inside."""
        ...

    def token(self) -> int:
        """A fresh token, as in a state: pages receive one every 50 ms."""
        ...

    def wait_change(self, timeout_s: float, last_version: int) -> int:
        """Wait until the state's version differs from `last_version` or the time is up; returns it.

        The version changes with everything in the state but token, heading and output.
        """
        ...

    def profiles(self) -> Message:
        """GET /profiles: {"revision", "chosen", "profiles", "fields"}."""
        ...

    def change_profile(self, request: Message, role: str) -> Message:
        """POST /profiles by a device of `role`: as profiles(), or {"reason", "detail"}."""
        ...

    def health(self) -> Message:
        """{part: {"state", "reason", "detail", "for_s"}} for GET /health."""
        ...


class RelayingPort:
    """A DriverPort that forwards everything to `port`; subclasses answer some calls themselves."""

    def __init__(self, port: DriverPort) -> None:
        self._port = port
        self.connect = port.connect
        self.welcome = port.welcome
        self.token = port.token
        self.wait_change = port.wait_change
        self.profiles = port.profiles
        self.change_profile = port.change_profile
        self.health = port.health

    def disconnect(self, client: int) -> None:
        self._port.disconnect(client)

    def receive(self, client: int, message: Message) -> list[Message]:
        return self._port.receive(client, message)

    def snapshot(self, client: int) -> Message:
        return self._port.snapshot(client)
