"""A plug-in's real process, called step by step in the virtual chair's time."""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any

from gazechair.base.child_records import DATA, FACTS, RecordReader
from gazechair.plugins.exchange import Facts, unpack_facts
from gazechair.plugins.found import Found

# Of real time: a plug-in that answers later hangs; its import may take longer.
ANSWER_S = 5.0
START_S = 20.0


class Failed(Exception):
    """Raised when the plug-in's process does not answer; the text is one plain line."""


class Paced:
    """Use as a context. `settings` as in the configuration; `how` as in gazechair.plugins.child."""

    def __init__(self, found: Found, settings: Mapping[str, Any], how: str = "paced") -> None:
        argument = {
            "kind": found.kind,
            "name": found.name,
            "entry": found.entry,
            "settings": dict(settings),
            "how": how,
        }
        self._command = [sys.executable, "-m", "gazechair.plugins.child", json.dumps(argument)]
        self._reader = RecordReader()
        self._waiting: list[tuple[bytes, bytes]] = []
        self._problem = ""
        self.facts = Facts("", "", {})

    def __enter__(self) -> Paced:
        path = os.pathsep.join(p for p in sys.path if p)
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=dict(os.environ, PYTHONPATH=path),
        )
        self._left_s = START_S
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: object, _trace: TracebackType | None
    ) -> None:
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        self._process.kill()
        self._process.wait()

    def ask(self, word: Mapping[str, Any]) -> bytes:
        """One step at the time in `word`; returns its value. Raises Failed."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(word).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # its last status says why
        return self.data()

    def data(self) -> bytes:
        """The next value. Raises Failed."""
        assert self._process.stdout is not None
        fd = self._process.stdout.fileno()
        end_s = time.monotonic() + self._left_s
        while True:
            while self._waiting:
                kind, payload = self._waiting.pop(0)
                if kind == DATA:
                    self._left_s = ANSWER_S
                    return payload
                if kind == FACTS:
                    self.facts = unpack_facts(payload)
                elif (status := json.loads(payload))["state"] == "lost":
                    self._problem = str(status["detail"])
            if not select.select([fd], [], [], max(0.0, end_s - time.monotonic()))[0]:
                raise Failed(f"it did not answer within {self._left_s:g} s")
            data = os.read(fd, 1 << 16)
            if not data:
                raise Failed(self._problem or "its process ended")
            self._waiting += self._reader.feed(data)
