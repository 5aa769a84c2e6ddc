"""Starts and ends the demo's processes: the simulator with its board, and the host daemon."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import gazesetup
from gazechair.people.pairing.local import NotRunning
from gazedemo import ending, pairing
from gazedemo.sim_control import SimControl
from gazesetup.family import dies_with_me, simulates_a_device

_START_S = 180.0  # a machine with many other programs takes a minute and more
_END_S = 8.0
CHAIR_CONFIG = """\
[board]
port = "{board}"
[lidar]
kind = "s2"
port = "{lidar}"
mask = [[123, -123]]
"""
"""The simulated chair's part of a configuration: `board` and `lidar` are the simulator's ports.
The chair itself blocks its lidar's view behind."""
_TWO_LIDARS = """\
[board]
port = "{board}"
[[lidar]]
name = "front"
kind = "s2"
port = "{lidar}"
x_m = 0.651
y_m = 0.376
mask = [[-180, -90]]
[[lidar]]
name = "rear"
kind = "s2"
port = "{lidar_2}"
x_m = -0.451
y_m = -0.376
heading_deg = 180
mask = [[-180, -90]]
"""
_HOST_CONFIG = """\
[camera]
kind = "http"
url = "{camera}"
[web]
port = {port}
state_folder = "{state}"
[driver]
mode = "continuous"
"""


class StackError(Exception):
    """Raised when a part did not start or has ended; one line: what, and where its log is."""


class Stack:
    """Use as a context: everything runs inside it, and nothing is left after it. If it is killed,
    only its folder is left: its processes end with the thread that entered it.

    `interpreter` is a MicroPython's path or "cpython"; `port` 0 takes any free one; `camera_url` ""
    shows what the simulated camera sees; `lidars`: 1 or 2; `prepare` fills the host's state folder
    before it starts; `more_config` follows the host's configuration, and
    `packages` is one more folder of packages, `environment` goes to the processes. Logs and ports
    live in `folder`, which goes at the end.
    """

    def __init__(
        self,
        interpreter: str,
        room: str = "living",
        profile: str = "3.1",
        port: int = 0,
        camera_url: str = "",
        more_config: str = "",
        packages: str = "",
        environment: Mapping[str, str] = MappingProxyType({}),
        lidars: int = 1,
        prepare: Callable[[Path], None] = lambda _state_folder: None,
    ) -> None:
        self._interpreter = interpreter
        self._room = room
        self._profile = profile
        self._port = port or _free_port()
        self._camera_url = camera_url
        self._more_config = more_config
        self._packages = packages
        self._environment = environment
        self._lidars = lidars
        self._prepare = prepare
        # Short: a unix socket's path must stay under 108 bytes, wherever the checkout is.
        self.folder = Path(tempfile.mkdtemp(prefix="gazechair-"))
        self._cookie = ""
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self.sim: SimControl | None = None
        self.paths: dict[str, Any] = {}

    @property
    def port(self) -> int:
        """The TCP port of the pages."""
        return self._port

    @property
    def url(self) -> str:
        """The address of the pages, for paired devices."""
        return f"http://127.0.0.1:{self._port}/"

    @property
    def state_folder(self) -> Path:
        """The host's state folder, with its local socket."""
        return self.folder / "state"

    def invitation(self, role: str = "driver", language: str = "") -> str:
        """An address that pairs the browser which opens it, once."""
        return pairing.invitation(self.state_folder, role, language)

    def cookie(self, role: str = "driver", name: str = "program") -> str:
        """The Cookie header of a newly paired program."""
        return pairing.cookie(self.state_folder, role, name)

    def __enter__(self) -> Stack:
        try:
            self._start()
        except BaseException:
            with ending.later():
                self._end()
            raise
        return self

    def __exit__(self, *_error: object) -> None:
        with ending.later():
            self._end()

    def control(self) -> SimControl:
        """The simulator's control connection."""
        assert self.sim is not None, "the stack is not running"
        return self.sim

    def health(self) -> dict[str, Any]:
        """The health of the host's parts (GET /health)."""
        if not self._cookie:
            self._cookie = self.cookie("viewer", "demo")
        request = urllib.request.Request(self.url + "health", headers={"Cookie": self._cookie})
        with urllib.request.urlopen(request, timeout=5) as answer:
            parts: dict[str, Any] = json.load(answer)
        return parts

    def check_alive(self) -> None:
        """Raise StackError when a process has ended by itself."""
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise StackError(f"{name} ended ({process.returncode}): {self._tail(name)}")

    def pid(self, name: str) -> int:
        """Process id of "simulator" or "host"."""
        return self._processes[name].pid

    def ended(self, name: str) -> int | None:
        """The exit code of "simulator" or "host"; None: it runs."""
        return self._processes[name].poll()

    def _start(self) -> None:
        with gazesetup.say("simulator and firmware"):
            words = ["-m", "gazesim", "--dir", str(self.folder), "--micropython"]
            words += [self._interpreter, "--room", self._room, "--profile", self._profile]
            words += ["--lidars", str(self._lidars)]
            self._spawn("simulator", words, stdout=subprocess.PIPE)
            self.paths = self._ready_line()
            self.sim = SimControl(Path(self.paths["control"]))
        with gazesetup.say("host and driver's page"):
            config = self.folder / "gazechair.toml"
            paths = self.paths | ({"camera": self._camera_url} if self._camera_url else {})
            text = (_TWO_LIDARS if self._lidars == 2 else CHAIR_CONFIG) + _HOST_CONFIG
            text = text.format(port=self._port, state=self.state_folder, **paths)
            config.write_text(text + self._more_config, "utf-8")
            self._prepare(self.state_folder)
            self.start_host()
            self._wait_for_parts()

    def start_host(self) -> None:
        """Start the daemon, again when it has ended. It ends with the thread that calls this."""
        config = self.folder / "gazechair.toml"
        self._spawn("host", ["-m", "gazechair", "run", "--config", str(config)])

    def _spawn(self, name: str, words: list[str], stdout: int | None = None) -> None:
        env = {**gazesetup.source_environment(), **self._environment}
        if self._packages:
            env["PYTHONPATH"] += os.pathsep + self._packages
        prepare = simulates_a_device if name == "simulator" else dies_with_me
        with ending.later(), open(self.folder / f"{name}.log", "ab") as log:
            self._processes[name] = subprocess.Popen(
                [sys.executable, *words],
                stdin=subprocess.DEVNULL,
                stdout=stdout if stdout is not None else log,
                stderr=log,
                env=env,
                cwd=gazesetup.ROOT,
                start_new_session=True,  # Ctrl-C must reach only us; we end them in order
                preexec_fn=prepare(signal.SIGTERM),
            )

    def _ready_line(self) -> dict[str, Any]:
        process = self._processes["simulator"]
        assert process.stdout is not None
        timer = threading.Timer(_START_S, process.kill)
        timer.name = "simulator-start-limit"
        timer.start()
        try:
            line = process.stdout.readline()
        finally:
            timer.cancel()
        if not line:
            raise StackError(f"the simulator did not start: {self._tail('simulator')}")
        paths: dict[str, Any] = json.loads(line)
        return paths

    def _wait_for_parts(self) -> None:
        end_s = time.monotonic() + _START_S
        missing = "no answer"
        while time.monotonic() < end_s:
            self.check_alive()
            with contextlib.suppress(OSError, ValueError, NotRunning):
                parts = self.health()
                missing = ", ".join(
                    f"{name} {part['state']}"
                    for name, part in parts.items()
                    if part["state"] != "ok" and not name.startswith(("input ", "mode "))
                )
                if not missing:
                    return
            time.sleep(0.1)
        raise StackError(f"not ready after {_START_S:g} s ({missing}): {self._tail('host')}")

    def _tail(self, name: str) -> str:
        lines = (self.folder / f"{name}.log").read_text(errors="replace").strip().splitlines()
        return " | ".join(lines[-3:]) or "no message"

    def log(self, name: str) -> str:
        """What "simulator" or "host" has printed."""
        return (self.folder / f"{name}.log").read_text(errors="replace")

    def _end(self) -> None:
        if self.sim is not None:
            self.sim.close()
            self.sim = None
        for name in ("host", "simulator"):
            process = self._processes.get(name)
            if process is None:
                continue
            process.terminate()
            try:
                process.wait(_END_S)
            except subprocess.TimeoutExpired:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            if process.stdout is not None:
                process.stdout.close()
        self._processes.clear()
        if os.environ.get("GAZECHAIR_KEEP_LOGS"):
            gazesetup.note(f"logs kept in {self.folder}")
        else:
            shutil.rmtree(self.folder, ignore_errors=True)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
