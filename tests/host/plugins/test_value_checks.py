"""An input beside its person's page, and a mode under a press: through Control, in virtual time."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from controlrig import Rig
from gazechair.plugins import NOTHING, STOP, Intent, choose, drive, hold, step
from gazechair.plugins.exchange import BadValue, Value
from gazechair.plugins.value_checks import InputRun, ModeRun
from gazelink import codes


class Person:
    """A driver's page that has armed, and one input; `wants` is what it senses each 20 ms."""

    def __init__(self, person: str = "driver") -> None:
        self.rig = Rig()
        self.rig.arm()
        self.clock = lambda: self.rig.now_s
        self.input = InputRun(self.rig.control, person, self.clock)
        self.press = 0
        self.stops = 0
        self.beats = True
        self.speaks = True
        self.wants = NOTHING
        self.run(0.4)
        self.rig.link.take()

    def want(self, intent: Intent, press: bool = True) -> None:
        """Sense this from now on, as a new press or the old one."""
        self.wants = intent
        self.press += press
        self.run(0.02)

    def rest(self) -> None:
        """Sense nothing for long enough."""
        self.want(NOTHING)
        self.run(0.32)

    def say(self, ahead_s: float = 0.0) -> None:
        value = Value(self.rig.now_s + ahead_s, self.press, self.wants, self.stops)
        self.input.take(value.pack())

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.02)):
            self.rig.now_s += 0.02
            if self.beats:
                self.rig.say(k="hb", token=self.rig.look()["token"])
            if self.speaks:
                self.say()
            self.rig.control.update()

    @property
    def command(self) -> tuple[int, int, int]:
        """Verb, linear and turn as the board has them now; a stop when their time is up."""
        command = self.rig.control._arbiter.command
        if command.ttl_deadline_s <= self.rig.now_s:
            return codes.STOP, 0, 0
        return command.verb, command.linear_permille, command.turn_permille


STILL = (codes.STOP, 0, 0)


@pytest.fixture
def person() -> Iterator[Person]:
    return Person()


def test_it_drives_beside_the_page_and_values_change_under_one_press(person: Person) -> None:
    person.want(drive(300, -20))
    assert person.command == (codes.DRIVE, 300, -20)
    assert person.rig.link.sent[0][3] == codes.DRIVER
    person.want(drive(700, 0), press=False)
    assert person.command == (codes.DRIVE, 700, 0)
    person.want(NOTHING)
    assert person.command == STILL


def test_a_hold_lasts_as_long_as_it_is_sensed(person: Person) -> None:
    person.want(hold("left"))
    person.run(2.0)
    assert person.command[0] == codes.LEFT
    person.speaks = False
    person.run(0.3)
    assert person.command == STILL
    person.speaks = True
    person.run(0.5)
    assert person.command == STILL, "the press that ended came back"
    person.rest()
    person.want(hold("left"))
    assert person.command[0] == codes.LEFT


def test_a_step_is_not_let_go_by_what_follows_it(person: Person) -> None:
    person.want(step("right"))
    person.want(NOTHING)
    command = person.rig.control._arbiter.command
    assert (command.verb, command.mode) == (codes.RIGHT, codes.STEP)
    person.speaks = False  # its process hangs: the step ends, too
    person.run(0.4)
    assert person.rig.control._arbiter.command.verb == codes.STOP


def test_what_is_pressed_at_the_start_or_through_a_stop_moves_nothing() -> None:
    person = Person()
    person.input.end()
    person.input = InputRun(person.rig.control, "driver", person.clock)
    person.want(hold("forward"))
    person.want(hold("left"))
    assert person.command == STILL
    person.rest()
    person.want(hold("forward"))
    assert person.command[0] == codes.FORWARD
    person.stops += 1
    person.run(0.1)
    assert person.command == STILL
    person.want(hold("left"))
    assert person.command == STILL


def test_a_stick_that_flickers_does_not_undo_anyones_stop(person: Person) -> None:
    for stop in ("stop", "disarm"):
        person.rest()
        person.want(drive(300, 0))
        assert person.command[0] == codes.DRIVE
        person.rig.say(k=stop)
        if stop == "disarm":
            person.rig.board(state=codes.DISARMED)
            person.rig.arm()
        for _ in range(50):
            for _ in range(14):
                person.want(NOTHING)
            person.want(drive(300, 0))
            assert person.command == STILL
    person.rest()
    person.want(drive(300, 0))
    assert person.command[0] == codes.DRIVE


def test_its_stop_stops_anyone_and_so_does_the_pages(person: Person) -> None:
    person.rig.forward()
    assert person.command[0] == codes.FORWARD
    person.wants = STOP
    person.stops += 1
    person.run(0.02)
    assert person.command == STILL
    person.rest()
    person.want(hold("right"))
    assert person.command[0] == codes.RIGHT
    person.rig.say(k="stop")
    person.run(0.2)
    assert person.command == STILL


def test_a_stop_that_a_newer_value_overtook_still_counts(person: Person) -> None:
    person.rig.forward()
    person.stops += 1  # the value that said so was never read
    person.run(0.02)
    assert person.command == STILL


def test_letting_go_of_it_does_not_stop_the_page(person: Person) -> None:
    person.want(hold("left"))
    person.rig.forward()
    assert person.command[0] == codes.FORWARD
    person.want(NOTHING)
    assert person.command[0] == codes.FORWARD


def test_another_persons_input_moves_nothing_but_stops() -> None:
    person = Person("caretaker")
    person.want(hold("forward"))
    assert person.command == STILL
    assert person.input.refused == "not_owner"
    person.rig.forward()
    person.stops += 1
    person.run(0.02)
    assert person.command == STILL


def test_it_cannot_arm_and_does_not_outlive_its_persons_page(person: Person) -> None:
    person.want(hold("forward"))
    person.beats = False
    person.run(0.4)
    assert person.command == STILL
    person.rig.control.disconnect(person.rig.page)
    assert ("order", codes.DISARM, codes.DRIVER) in person.rig.link.take()


def test_its_end_ends_its_motion_at_once(person: Person) -> None:
    person.want(step("left"))
    person.input.end()
    assert person.rig.control._arbiter.command.verb == codes.STOP


@pytest.mark.parametrize("ahead_s", [0.003, 0.1, 1e9])
def test_a_time_from_the_future_is_a_lie(person: Person, ahead_s: float) -> None:
    person.want(hold("forward"))
    with pytest.raises(BadValue, match="future"):
        person.say(ahead_s)


def test_old_values_move_nothing_and_if_they_go_on_are_a_lie(person: Person) -> None:
    person.want(hold("forward"))
    person.speaks = False

    def say_old(seconds: float) -> None:
        for _ in range(round(seconds / 0.02)):
            person.run(0.02)
            person.say(-0.26)

    say_old(0.36)
    assert person.command == STILL
    say_old(0.5)
    assert person.command == STILL
    with pytest.raises(BadValue, match="old"):
        say_old(0.6)


def test_out_of_order_is_ignored(person: Person) -> None:
    person.want(hold("forward"))
    person.wants = NOTHING
    person.say(-0.1)
    assert person.command[0] == codes.FORWARD


# -- modes


class Riding(Person):
    """The page holds the tile of the mode `ahead`, whose process says `steers` each 20 ms."""

    def __init__(self) -> None:
        super().__init__()
        self.offer()
        self.mode = ModeRun(self.rig.control, "ahead", self.clock)
        self.steers: Intent | None = drive(400, 50)
        self.edge = 0
        self.held = False
        self.refused: list[str] = []

    def offer(self) -> None:
        self.rig.control.offer_mode("ahead", {"icon": "●", "names": {"en": "Ahead"}})

    def hold_tile(self) -> None:
        self.edge += 1
        self.held = True

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.02)):
            super().run(0.02)
            if getattr(self, "held", False):
                token = self.rig.look()["token"]
                sent = self.rig.say(k="mode", mode="ahead", edge=self.edge, token=token)
                self.refused += [one["reason"] for one in sent]
                context = self.rig.control.mode_context()
                if context.mode and self.steers is not None:
                    value = Value(self.rig.now_s, context.press, self.steers)
                    self.mode.take(value.pack())


def test_a_mode_drives_while_its_tile_is_held() -> None:
    riding = Riding()
    assert riding.rig.control.welcome(riding.rig.page)["modes"][0]["mode"] == "ahead"
    riding.hold_tile()
    riding.run(1.0)
    assert riding.command == (codes.DRIVE, 400, 50)
    riding.held = False
    riding.rig.say(k="stop")
    assert riding.command == STILL


def test_a_mode_that_says_nothing_ends_the_press_before_or_after_it_drove() -> None:
    for first_s in (0.0, 0.5):
        riding = Riding()
        riding.hold_tile()
        riding.run(first_s)
        riding.steers = None
        riding.run(0.32)
        assert riding.command == STILL
        riding.steers = drive(400, 0)
        riding.run(0.5)
        assert riding.command == STILL
        assert riding.refused == ["needs_new_command"]
        riding.hold_tile()
        riding.run(0.1)
        assert riding.command[0] == codes.DRIVE


def test_a_mode_that_has_arrived_ends_the_press() -> None:
    riding = Riding()
    riding.hold_tile()
    riding.run(0.2)
    riding.steers = NOTHING
    riding.run(0.04)
    assert riding.command == STILL


def test_without_the_persons_proof_a_mode_stops() -> None:
    riding = Riding()
    riding.hold_tile()
    riding.run(0.2)
    riding.held = False
    press = riding.rig.control.mode_context().press
    for _ in range(20):
        riding.run(0.02)
        riding.mode.take(Value(riding.rig.now_s, press, drive(400, 0)).pack())
    assert riding.command == STILL


def test_a_mode_that_nobody_holds_moves_nothing() -> None:
    riding = Riding()
    for press in (0, 1, 5):
        riding.mode.take(Value(riding.rig.now_s, press, drive(400, 0)).pack())
        assert riding.command == STILL
    riding.rig.forward()
    riding.mode.take(Value(riding.rig.now_s, 0, drive(400, 0)).pack())
    assert riding.command[0] == codes.FORWARD


def test_a_mode_that_is_lost_ends_and_cannot_be_chosen() -> None:
    riding = Riding()
    riding.hold_tile()
    riding.run(0.2)
    riding.rig.control.offer_mode("ahead", None)
    assert riding.command == STILL
    riding.hold_tile()
    riding.run(0.1)
    assert riding.refused == ["no_answer"]  # once per press
    riding.offer()
    riding.run(0.2)
    assert riding.command == STILL  # that press was refused for good
    riding.hold_tile()
    riding.run(0.1)
    assert riding.command[0] == codes.DRIVE


def test_an_input_can_hold_a_mode() -> None:
    riding = Riding()
    riding.want(choose("ahead"))
    press = riding.rig.control.mode_context().press
    riding.mode.take(Value(riding.rig.now_s, press, drive(200, 0)).pack())
    assert riding.command == (codes.DRIVE, 200, 0)
    riding.want(NOTHING)
    assert riding.command == STILL


def test_a_mode_says_nothing_but_how_to_drive() -> None:
    riding = Riding()
    with pytest.raises(BadValue, match="mode"):
        riding.mode.take(Value(riding.rig.now_s, 1, hold("left")).pack())
