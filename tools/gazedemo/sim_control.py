"""Client of the simulator's control socket: reads the truth, injects faults, moves the chair."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

_REPLY_S = 10.0


class SimControl:
    """One connection; not for several threads."""

    def __init__(self, path: Path) -> None:
        """Connect to the socket at `path`; OSError when no simulator listens there."""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(_REPLY_S)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile("rb")

    def close(self) -> None:
        """End the connection."""
        self._lines.close()
        self._socket.close()

    def do(self, what: str, **arguments: Any) -> dict[str, Any]:
        """One request; RuntimeError with the simulator's reason when it refuses."""
        self._socket.sendall(json.dumps({"do": what, **arguments}).encode() + b"\n")
        reply: dict[str, Any] = json.loads(self._lines.readline())
        if "error" in reply:
            raise RuntimeError(f"simulator: {reply['error']}")
        return reply

    def truth(self) -> dict[str, Any]:
        """The chair's position and motion, as in World.truth()."""
        return self.do("truth")

    def wipers(self) -> tuple[int, int]:
        """What the pot's registers hold now: (linear, turn) counts."""
        linear, turn = self.truth()["wipers"]
        return linear, turn

    def wait(
        self, condition: Callable[[dict[str, Any]], bool], limit_s: float, what: str
    ) -> dict[str, Any]:
        """Poll the truth until `condition`; returns it. TimeoutError naming `what`."""
        end_s = time.monotonic() + limit_s
        while True:
            truth = self.truth()
            if condition(truth):
                return truth
            if time.monotonic() > end_s:
                raise TimeoutError(f"not within {limit_s:g} s: {what}; the chair: {truth}")
            time.sleep(0.02)
