"""The whole chair in virtual time for a day: host, state folder, alerts, two pages."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any
from unittest import mock

from gazechair.alerts.service import LOOK_S, Alerts
from gazechair.base.health import OK, HealthRegistry
from gazechair.config.settings import Config
from gazechair.driving import arbiter
from gazechair.driving.control import HEARTBEAT_MS, Control
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.people.profiles import Profiles, house_fields
from gazelink import codes
from gazemeasure.obstacles.firmware import DENSE, Eyes
from gazereplay.recording import WALL_NS, Recording
from gazesim.chair_rig import ChairRig
from gazesim.lockstep_link import LockstepLink

_UPDATE_MS = round(1000 * arbiter.LOOK_S)
_BEAT_MS = 100
_LOOK_MS = round(1000 * LOOK_S)
_GATHER_MS = 20
_KEEP_MS = 1000
_READY_MS = 8000
_STOP = {"k": "stop"}


class Page:
    """A page with its socket."""

    def __init__(self, host: Host, role: str) -> None:
        self._host = host
        self._client = host.control.connect(role)
        self._edge = 0
        self._held: dict[str, Any] = {}
        self.refused: dict[str, int] = {}

    def say(self, **message: Any) -> None:
        """Send a message with a fresh token."""
        control = self._host.control
        for answer in control.receive(self._client, {**message, "token": control.token()}):
            self.refused[answer["reason"]] = self.refused.get(answer["reason"], 0) + 1

    def press(self, **button: Any) -> None:
        """A new press, active from now on."""
        self._edge += 1
        self._held = {**button, "edge": self._edge}
        self.say(**self._held)

    def release(self) -> None:
        """Release the button."""
        self._held = {}
        self.say(**_STOP)

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of the page."""
        if now_ms % _BEAT_MS == 0:
            self.say(k="hb")
        if self._held and now_ms % HEARTBEAT_MS == 0:
            self.say(**self._held)

    def shown(self) -> dict[str, Any]:
        """The state that it receives now."""
        return self._host.control.snapshot(self._client)


class Host:
    """The daemon's parts without its threads, over one state folder."""

    def __init__(self, chair: DayChair, folder: Path) -> None:
        self._chair = chair
        dice = random.Random(chair.now_ms)
        self.link = LockstepLink(chair.cable, chair.now_s, lambda: dice.randrange(1, 65536))
        self.parts = HealthRegistry(chair.now_s)
        for name in ("board", "lidar", "camera"):
            self.parts.part(name).set(OK)
        config, speed_cap = Config(), SpeedCapStore(folder)
        self.alerts = Alerts(
            config, folder, self.parts, chair.now_s, lambda: WALL_NS / 1e9 + chair.now_s()
        )
        with mock.patch("secrets.randbelow", dice.randrange):
            self.control = Control(
                config,
                self.link,
                self.parts,
                clock=chair.now_s,
                profiles=Profiles(folder, house_fields(config)),
                speed_cap=speed_cap,
                alerts=self.alerts,
            )
        self._speed_cap = speed_cap
        self.alerts.watch(self.control)
        self.driver = Page(self, "driver")
        self.caretaker = Page(self, "caretaker")
        self._eyes = Eyes(gather_ms=_GATHER_MS)
        self.link.on_zone = self._eyes.receive
        chair.world.lidar.receive(DENSE)

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of the daemon."""
        self.link.one_ms()
        seen = self._eyes.step(self._chair.scanned, now_ms)
        if seen is not None:
            self.control.clearance(seen)
        if now_ms % _UPDATE_MS == 0:
            self.control.update()
        if now_ms % _LOOK_MS == 0:
            self.alerts.look()
        if now_ms % _KEEP_MS == 0:
            self.alerts.keep()
            self._speed_cap.write()
        self.driver.one_ms(now_ms)
        self.caretaker.one_ms(now_ms)


class DayChair(ChairRig):
    """The chair; its state, and its log with the board's trace, are in `folder`."""

    def __init__(self, folder: Path, room: str = "open", record: bool = False) -> None:
        super().__init__(room)
        self._folder = folder
        self.host: Host | None = Host(self, folder)
        self.synced: dict[int, int] = {}
        """{ms: bytes of the log's file} after each sync."""
        self._recording: Recording | None = None
        if record:
            self._recording = Recording(self, self.host.link.protocol, folder / "log")

    @property
    def driver(self) -> Page:
        """The driver's page."""
        assert self.host is not None
        return self.host.driver

    @property
    def caretaker(self) -> Page:
        """The caretaker's page."""
        assert self.host is not None
        return self.host.caretaker

    def one_ms(self) -> None:
        """One step."""
        super().one_ms()
        if self._recording is not None and self._recording.after_ms():
            self.synced[self.now_ms] = self._recording.path.stat().st_size

    def host_ms(self) -> None:
        """One millisecond of the host, if it runs."""
        if self.host is not None:
            self.host.one_ms(self.now_ms)

    def close(self) -> Path:
        """Finish the recording; returns its file."""
        assert self._recording is not None
        return self._recording.close()

    def kill_host(self) -> None:
        """As by SIGKILL."""
        assert self.host is not None
        self.host.link.close()
        self.host = None

    def start_host(self) -> None:
        """Start a new daemon with the same state; the pages connect to it by themselves."""
        self.host = Host(self, self._folder)

    def ready(self) -> None:
        """Run until nothing prevents arming."""
        self.until(lambda: self._snapshot().get("arm_reason") == "none", _READY_MS)

    def arm(self) -> None:
        """Arm as the driver, with a request each second. Raises AssertionError after 8 s."""
        for _ in range(_READY_MS // 1000):
            if not self.armed():
                self.driver.say(k="arm")
            self.run(20)
            for _ in range(98):
                if self.armed() and self._snapshot().get("you"):
                    return
                self.run(10)
        raise AssertionError(f"not armed: {self.why()}")

    def _snapshot(self) -> dict[str, Any]:
        return {} if self.host is None else self.host.driver.shown()

    def moves_after(self, limit_ms: int = 200, **button: Any) -> int | None:
        """ms from a new press of the driver to the wipers; None: overruled."""
        self.driver.press(**button)
        for ms in range(limit_ms):
            if not self.neutral():
                return ms
            self.one_ms()
        return None

    def allowed(self, verb: str) -> bool:
        """True if the board does not block this direction."""
        return not self.app.obstacles.blocked & 1 << codes.DIRECTIONS.index(verb)
