"""An arbiter with a connected board and pages, in virtual time."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from gazechair.driving.arbiter import Arbiter
from gazechair.driving.messages import Arm, Beat, Drive, Take
from gazechair.driving.refusal import Refusal
from gazelink import codes
from gazesim.board_limits import LIMITS


class Scene:
    """An arbiter with a connected board and one driver's page; the test sets the time."""

    def __init__(self) -> None:
        self.now_s = 50.0
        self.arbiter = Arbiter(last_edge=10)
        self.arbiter.ttl_s = LIMITS.command_ttl_ms / 1000
        self.state = codes.DISARMED
        self.session = 7
        self.board()
        self.page = self.arbiter.connect("driver", self.now_s)

    def board(self, state: int | None = None, edge: int = 0) -> None:
        if state is not None:
            self.state = state
        self.arbiter.board(self.session, self.state, edge, self.now_s)

    def token(self) -> int:
        return self.arbiter.tokens.token(self.now_s)

    def beat(self, page: int | None = None) -> None:
        self.arbiter.receive(page or self.page, Beat(self.token()), self.now_s)

    def take(self, page: int) -> Refusal | None:
        return self.arbiter.receive(page, Take(self.token()), self.now_s)

    def arm(self, page: int | None = None) -> Refusal | None:
        return self.arbiter.receive(page or self.page, Arm(self.token()), self.now_s)

    def drive(
        self,
        edge: int,
        page: int | None = None,
        verb: int = codes.FORWARD,
        mode: int = codes.CONTINUOUS,
        age_ms: int = 0,
    ) -> str | None:
        message = Drive(verb, mode, edge, self.token() - age_ms)
        refusal = self.arbiter.receive(page or self.page, message, self.now_s)
        return None if refusal is None else refusal.reason

    def say(self, message: object, page: int | None = None) -> Refusal | None:
        return self.arbiter.receive(page or self.page, message, self.now_s)  # type: ignore[arg-type]

    def wait(self, seconds: float, beating: bool = True) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s - 1e-9:
            self.now_s += 0.01
            if beating:
                self.beat()
            self.arbiter.tick(self.now_s)

    @property
    def verb(self) -> int:
        return self.arbiter.command.verb

    @property
    def moving(self) -> bool:
        """A motion with time to live left."""
        command = self.arbiter.command
        return command.verb != codes.STOP and command.ttl_deadline_s > self.now_s


@pytest.fixture
def scene() -> Scene:
    return Scene()


@pytest.fixture
def armed(scene: Scene) -> Scene:
    assert scene.arm() is None
    scene.arbiter.take_orders()
    scene.board(codes.ARMING)
    scene.board(codes.ARMED)
    scene.wait(1.1)
    return scene


@pytest.fixture(scope="session")
def new_scene() -> Callable[[], Scene]:
    """A maker of scenes."""
    return Scene
