"""An auto mode: started once, supervised by fresh proofs, ended by anything else."""

from __future__ import annotations

import pytest

from gazechair.driving.messages import (
    DISARM,
    EMERGENCY,
    LET_GO,
    STOP,
    Drive,
    HoldBypass,
    UseMode,
    Watch,
)
from gazelink import codes
from host.driving.conftest import Scene

MODE = "go"


class Auto(Scene):
    """A scene with a mode that drives by itself."""

    def __init__(self) -> None:
        super().__init__()
        self.arbiter.auto_modes = frozenset((MODE,))
        self.edge = 0
        self.arm()
        self.board(codes.ARMED)

    def start(self, page: int | None = None) -> None:
        self.edge += 1
        assert self.say(UseMode(MODE, self.edge, self.token()), page) is None
        self.plan()

    def plan(self, life_s: float = 0.15, output: tuple[int, int] | None = (300, 50)) -> None:
        mode, number = self.arbiter.mode_press
        self.arbiter.mode_output(mode, number, output, self.now_s + life_s, self.now_s, True)

    def go_on(self, seconds: float) -> None:
        """Time passes while the planner plans."""
        for _ in range(round(seconds * 50)):
            self.wait(0.02)
            self.plan()

    @property
    def drives(self) -> bool:
        return self.arbiter.auto == MODE and self.verb == codes.DRIVE


@pytest.fixture
def auto() -> Auto:
    scene = Auto()
    scene.start()
    return scene


def test_one_press_starts_it_and_nobody_holds_it(auto: Auto) -> None:
    auto.go_on(1.0)
    auto.board(edge=auto.arbiter.command.edge)
    auto.go_on(1.0)
    assert auto.drives
    command = auto.arbiter.command
    assert (command.mode, command.owner) == (codes.AUTO, codes.DRIVER)
    assert (command.linear_permille, command.turn_permille) == (300, 50)
    assert command.ttl_deadline_s <= auto.now_s + 0.15
    auto.say(LET_GO)  # nobody held it
    assert auto.drives


def test_it_asks_for_nothing_until_the_board_has_begun_it(auto: Auto) -> None:
    """One that begins where it is blocked would be over for the board, and wait for nothing."""

    def requested() -> tuple[int, int, int]:
        command = auto.arbiter.command
        return command.verb, command.linear_permille, command.turn_permille

    for _ in range(2):
        number = auto.arbiter.command.edge
        assert requested() == (codes.DRIVE, 0, 0)
        auto.board(edge=number % 255 + 1)  # another press
        auto.go_on(0.1)
        assert requested() == (codes.DRIVE, 0, 0)
        auto.board(edge=number)
        assert requested() == (codes.DRIVE, 300, 50)
        auto.go_on(0.1)
        assert auto.drives
        auto.start()  # another press on the same mode


def test_one_that_the_board_overrules_before_it_asked_for_anything_is_over(auto: Auto) -> None:
    """The chair still rolls past something: the board has begun nothing that could wait."""
    rolls = codes.OBSTACLE_BACKWARD
    auto.arbiter.board(auto.session, codes.ARMED, auto.arbiter.command.edge, auto.now_s, rolls)
    assert auto.arbiter.auto == ""
    auto.start()
    auto.board(edge=auto.arbiter.command.edge)
    auto.arbiter.board(auto.session, codes.ARMED, auto.arbiter.command.edge, auto.now_s, rolls)
    assert auto.drives  # it waits


def test_supervision_is_only_ever_as_young_as_its_proof(auto: Auto) -> None:
    began_s = auto.now_s
    auto.go_on(1.0)
    assert auto.arbiter.command.watched_s == pytest.approx(began_s, abs=0.002)
    auto.say(Watch(auto.token() - 200))
    watched_s = auto.arbiter.command.watched_s
    assert watched_s == pytest.approx(auto.now_s - 0.2, abs=0.002)
    auto.say(Watch(auto.token() - 251))  # too long on its way
    auto.say(Watch(auto.token() + 100))  # from the future
    auto.say(Watch(auto.token() - 230))  # older than what is known
    assert auto.arbiter.command.watched_s == watched_s
    assert auto.arbiter.command.supervision(auto.now_s)[2] in (200, 201)


def test_who_watches_is_a_caretaker_or_whoever_drives(auto: Auto) -> None:
    """Not another driver: their page may lie open in another room."""
    caretaker = auto.arbiter.connect("caretaker", auto.now_s)
    for watching, owner in ((caretaker, codes.CARETAKER), (None, codes.DRIVER)):
        auto.go_on(0.3)
        auto.say(Watch(auto.token()), watching)
        assert auto.arbiter.command.watcher == owner
    before = auto.arbiter.command
    auto.go_on(0.3)
    assert auto.say(Watch(auto.token()), auto.arbiter.connect("driver", auto.now_s)) is None
    assert auto.arbiter.command.watched_s == before.watched_s
    refusal = auto.say(Watch(auto.token()), auto.arbiter.connect("viewer", auto.now_s))
    assert refusal is not None
    assert refusal.reason == "not_allowed"
    assert auto.arbiter.command.watched_s == before.watched_s


def test_a_held_switch_supervises(auto: Auto) -> None:
    switch = auto.arbiter.connect("driver", auto.now_s, is_input=True)
    auto.say(UseMode(MODE, 1, auto.token()), switch)
    auto.plan()
    for _ in range(50):
        auto.wait(0.02)
        auto.say(UseMode(MODE, 1, auto.token()), switch)
        auto.plan()
    assert auto.drives
    assert auto.arbiter.command.watched_s == pytest.approx(auto.now_s, abs=0.002)
    auto.say(LET_GO, switch)
    assert auto.drives  # until its supervision is over: the board counts
    auto.arbiter.disconnect(switch)
    assert not auto.drives


@pytest.mark.parametrize("message", [STOP, DISARM, EMERGENCY])
def test_any_stop_by_anyone_ends_it(auto: Auto, message: object) -> None:
    caretaker = auto.arbiter.connect("caretaker", auto.now_s)
    auto.say(message, caretaker)
    assert not auto.drives
    auto.go_on(0.5)
    assert auto.verb == codes.STOP
    assert auto.arbiter.auto_over == MODE


def test_any_press_by_anyone_ends_it(auto: Auto) -> None:
    caretaker = auto.arbiter.connect("caretaker", auto.now_s)
    assert auto.drive(1, caretaker) == "not_owner"
    assert not auto.drives
    assert auto.verb == codes.STOP
    auto.start()
    auto.say(HoldBypass(1, auto.token()), caretaker)
    assert not auto.drives
    auto.start()
    auto.edge += 1
    assert auto.drive(auto.edge) is None
    assert not auto.drives
    assert auto.verb == codes.FORWARD
    auto.say(Drive(codes.FORWARD, 1, auto.edge, auto.token()))
    auto.go_on(0.2)
    assert auto.arbiter.command.mode == codes.CONTINUOUS


def test_the_same_press_said_again_starts_nothing_anew(auto: Auto) -> None:
    number = auto.arbiter.command.edge
    auto.say(UseMode(MODE, auto.edge, auto.token()))
    assert auto.drives
    assert auto.arbiter.command.edge == number
    auto.say(STOP)
    refusal = auto.say(UseMode(MODE, auto.edge, auto.token()))
    assert refusal is not None
    assert refusal.reason == "needs_new_command"
    assert not auto.drives
    auto.start()
    assert auto.drives
    assert auto.arbiter.command.edge != number


def test_it_ends_with_its_planner_with_its_page_and_with_the_session(auto: Auto) -> None:
    auto.wait(0.16)
    assert not auto.drives
    auto.start()
    auto.wait(0.1)
    auto.plan()
    for _ in range(20):
        auto.wait(0.02, beating=False)
        auto.plan()
    assert not auto.drives  # its owner's page is silent
    auto.beat()
    auto.start()
    auto.session += 1
    auto.board()
    assert not auto.drives


def test_what_the_board_ended_is_over_and_what_it_overrules_waits(auto: Auto) -> None:
    number = auto.arbiter.command.edge
    auto.board(edge=number)
    waits = (*range(codes.OBSTACLE_FORWARD, codes.OBSTACLE_RIGHT + 1), codes.ABOVE_CREEP)
    for override in waits:
        auto.arbiter.board(auto.session, codes.ARMED, number, auto.now_s, override)
        assert auto.drives
    auto.arbiter.board(auto.session, codes.ARMED, 99, auto.now_s, codes.SUPERVISION_LOST)
    assert auto.drives  # of another press
    auto.arbiter.board(auto.session, codes.ARMED, number, auto.now_s, codes.SUPERVISION_LOST)
    assert not auto.drives
    auto.plan()
    assert auto.arbiter.command.ttl_deadline_s == 0.0
    assert auto.arbiter.auto_over == MODE
    auto.start()
    assert auto.drives
    assert auto.arbiter.auto_over == ""


def test_at_its_own_end_nothing_is_left_to_release(auto: Auto) -> None:
    auto.plan(output=None)
    assert not auto.drives
    assert auto.verb == codes.STOP
    assert auto.arbiter.auto_over == ""


def test_a_held_mode_is_held_as_ever() -> None:
    auto = Auto()
    auto.arbiter.auto_modes = frozenset()
    auto.start()
    assert auto.arbiter.command.mode == codes.CONTINUOUS
    auto.go_on(0.5)
    assert auto.arbiter.command.ttl_deadline_s < auto.now_s
    assert auto.arbiter.auto == ""
