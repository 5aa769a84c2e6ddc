"""A new board and a caretaker's phone, in virtual time: page messages move a simulated chair."""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Clearance
from gazechair.board.events import SettingReply
from gazechair.board.link import BoardLink
from gazechair.commissioning.tune.forward import ForwardNumbers
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config.settings import Config, LidarConfig
from gazechair.driving.control import Control
from gazechair.first_drive.floor_marks import FloorMarks
from gazechair.first_drive.guide import Guide
from gazechair.first_drive.port import FirstDrivePort
from gazechair.first_drive.record import Record
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.floor_store import FloorStore
from gazechair.sensing.lidar.recorded import BEAMS
from gazechair.web.page_client import decode
from gazelink import codes
from gazesim.chair_rig import CLEARANCE_MS, ChairRig
from gazesim.floor_view import Eye, Floor, FloorView
from gazesim.lockstep_host import UPDATE_MS
from gazesim.lockstep_link import LockstepLink
from gazesim.lockstep_page import Page
from measuredchair import Measured

AHEAD_MM = 1500
EYE = Eye(640, 480, field_deg=68.0, height_m=1.21, down_deg=27.0, left_deg=2.0, forward_m=0.25)
_MARKS_CM = [(120, 30), (120, -30), (180, 50), (180, -50), (250, 70), (250, -70), (200, 0)]
_CHAIR_MM, _WALL_MM = 220, 3000
_SCAN_MS = 500
_TURNS = 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
_HIDDEN_DEG = 124


def scan() -> bytes:
    """What the lidar sees: walls all round, the chair itself behind it."""
    degrees = (np.arange(BEAMS) + 0.5) * (360.0 / BEAMS) - 180.0
    mm = np.where(np.abs(degrees) > _HIDDEN_DEG, _CHAIR_MM, _WALL_MM)
    return mm.astype("<u2").tobytes()


def marks() -> list[list[float]]:
    """Marks on the floor as a phone sends them: shares of the picture, cm ahead and to the left."""
    seen = [EYE.pixel(x / 100, y / 100) for x, y in _MARKS_CM]
    size = EYE.width_px, EYE.height_px
    return [
        [float(u / size[0]), float(v / size[1]), *place]
        for (u, v), place in zip(seen, _MARKS_CM, strict=True)
    ]


@functools.cache
def _picture() -> bytes:
    return FloorView(EYE, Floor()).jpeg(0.0, 0.0, 0.0)


class _Link(LockstepLink):
    # With BoardLink.setting: time passes until the board has answered.

    pass_ms: Callable[[], None]

    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None:
        self.reply = None
        self.protocol.request_setting(request, index, value)
        for _ in range(round(timeout_s * 1000)):
            self.pass_ms()
            reply = self.reply
            if reply is not None and (reply.request, reply.index) == (request, index):
                return reply
        return None


class _Guide(Guide):
    # Its steps run in the test's own thread.

    due: Callable[[], None] | None = None

    def begin(self, step: str, value: Any = None) -> None:
        self.due = self.prepare(step, value)


class FirstDriveRig(ChairRig):
    """The chair, two pages, and a host whose lidar sees nothing in the path of a turn."""

    def __init__(self, folder: Path | None = None) -> None:
        super().__init__()
        self.link = _Link(self.cable, self.now_s, iter(range(7, 9999)).__next__)
        self.link.pass_ms = self.one_ms
        self.parts = HealthRegistry(self.now_s)
        for name in ("board", "lidar", "camera"):
            self.parts.part(name).set(OK)
        config = Config(lidar=(LidarConfig(kind="s2", x_m=0.5),))
        profiles = Profiles(folder, house_fields(config))
        self.link_as_host = cast(BoardLink, self.link)
        steering = Control(
            config, self.link_as_host, self.parts, clock=self.now_s, profiles=profiles
        )
        self.masks: list[tuple[LidarConfig, ...]] = []
        self.guide = _Guide(
            config,
            self.link_as_host,
            self.parts,
            steering,
            profiles,
            Record(folder),
            self.masks.append,
            self.now_s,
            lambda seconds: self.run(max(1, round(seconds * 1000))),
            lambda: Measured(self)() if self.knows_place else None,
            lambda profile, found: self.kept.append((profile, found)),
            None if folder is None else FloorMarks(FloorStore(folder), lambda: self.picture),
            (lambda *_: None) if folder is None else ForwardStore(folder).step_ms,
        )
        self.picture: bytes | None = _picture()
        self.knows_place = True
        self.kept: list[tuple[str, ForwardNumbers]] = []
        self.steering = steering
        self.control = FirstDrivePort(steering, self.guide)
        self.inbox: deque[tuple[int, str]] = deque()
        self.frozen = False
        self.refusals: list[str] = []
        self.sees = True
        self.watch: Callable[[], None] = lambda: None
        self.caretaker = Page(cast(Any, self), "caretaker")
        self.driver = Page(cast(Any, self), "driver")
        self._edge = 0
        self._holding = ""

    def look(self, client: int) -> dict[str, Any]:
        """What a page is sent."""
        return self.control.snapshot(client)

    def host_ms(self) -> None:
        """Pages, host, lidar."""
        now_ms = self.now_ms
        for page in (self.caretaker, self.driver):
            page.one_ms(now_ms)
        if self._holding and now_ms % UPDATE_MS == 0:
            self._say_held(self._holding)
        while self.inbox:
            client, text = self.inbox.popleft()
            message = decode(text)
            assert isinstance(message, dict)
            self.refusals += [r["reason"] for r in self.control.receive(client, message)]
        self.link.one_ms()
        if self.sees and now_ms % CLEARANCE_MS == 0:
            # As with one lidar in front: no turn is seen whole.
            clearance = Clearance(
                0, codes.SIMULATED, self.now_s() - 0.02, unseen=_TURNS, forward_mm=AHEAD_MM
            )
            self.steering.clearance(self.guide.seen(clearance))
        if now_ms % _SCAN_MS == 0:
            self.guide.scan("lidar", self.now_s(), scan())
        if now_ms % UPDATE_MS == 0:
            self.steering.update()
            self.guide.look()
        self.watch()

    # What the caretaker's page does

    def ready(self) -> None:
        """Wait until nothing prevents arming."""
        self.until(lambda: self.link.state() is not None, 6000)
        self.until(lambda: self.caretaker.shown.get("arm_reason") == "none", 6000)

    def rows(self) -> dict[str, dict[str, Any]]:
        """GET /first-drive, by step."""
        return {row["step"]: row for row in self.guide.status()["steps"]}

    def post(self, **posted: Any) -> str:
        """POST /first-drive, and the step's end: "" or the reason why not."""
        refused = self.guide.ask(posted)
        return refused[0] if refused else self._finish()

    def hold(self, step: str) -> str:
        """Press and hold a step's button until it ends; "" or the reason why not."""
        self.press(step)
        self.run(60)
        if self.guide.due is None:
            self.let_go()
            return self.refusals[-1]
        reason = self._finish()
        self.let_go()
        self.run(400)  # the board arms again once no command is active for a while
        return reason

    def press(self, step: str) -> None:
        """Begin to press."""
        self._edge += 1
        self._holding = step

    def let_go(self) -> None:
        """The button is let go."""
        self._holding = ""
        self.caretaker.say(k="step", held=False)

    def forget(self) -> None:
        """Send no more messages of the pressed button."""
        self._holding = ""

    def _say_held(self, step: str) -> None:
        self.caretaker._send_fresh(k="step", step=step, held=True, edge=self._edge)

    def _finish(self) -> str:
        work, self.guide.due = self.guide.due, None
        if work is not None:
            work()
        ended = self.guide.status()["run"]["ended"]
        return str(ended["reason"]) if ended else ""
