"""How assist may change a command: only the driver's held Vooruit, and within limits."""

import itertools
import math
import random

import pytest

from gazechair.assist.assist import FULL, MOST_TURN
from gazechair.assist.steering import OLD_S, Advised, Steering
from gazechair.board.board_commands import STOP_COMMAND, Command
from gazelink import codes

NOW_S = 100.0


def held(edge=7, verb=codes.FORWARD, mode=codes.CONTINUOUS, owner=codes.DRIVER, till_s=NOW_S + 0.3):
    return Command(verb, mode, edge, owner, till_s, cap_permille=640)


def working(press=7, born_s=NOW_S):
    steering = Steering()
    steering.ready_s = NOW_S
    steering.advised = Advised(press, 400, 200, True, born_s)
    return steering


def test_a_held_vooruit_is_steered():
    sent = working().steer(held(), True, NOW_S)
    assert (sent.verb, sent.linear_permille, sent.turn_permille) == (codes.DRIVE, 400, 200)
    assert (sent.edge, sent.owner, sent.ttl_deadline_s, sent.cap_permille) == (
        7,
        codes.DRIVER,
        NOW_S + 0.3,
        640,
    )


@pytest.mark.parametrize(
    "command",
    [
        STOP_COMMAND,
        held(verb=codes.LEFT),
        held(verb=codes.BACKWARD),
        held(verb=codes.DRIVE),
        held(mode=codes.STEP),
        held(mode=codes.TUNE),
        held(mode=codes.AUTO),
        held(owner=codes.CARETAKER),
    ],
)
def test_everything_else_stays_as_it_is(command):
    steering = working()
    assert steering.steer(command, True, NOW_S) is command
    assert not steering.steers(NOW_S)


def test_off_or_not_seeing_it_is_no_other_command():
    command = held()
    assert working().steer(command, False, NOW_S) is command
    blind = working()
    blind.ready_s = NOW_S - 1.0
    assert blind.steer(command, True, NOW_S) is command
    # It keeps its verb, although assist works again.
    blind.ready_s = NOW_S
    assert blind.steer(command, True, NOW_S) is command


@pytest.mark.parametrize("born_s", [NOW_S - OLD_S - 0.01, NOW_S + 5.0, math.inf, -math.inf])
def test_advice_that_is_old_or_of_the_future_is_none(born_s):
    steering = working(born_s=born_s)
    steering.steer(held(), True, NOW_S)
    sent = steering.steer(held(till_s=NOW_S + 1.0), True, NOW_S + 0.2)
    assert (sent.linear_permille, sent.turn_permille) == (FULL, 0)


def test_another_presss_advice_is_none():
    steering = working(press=8)
    steering.steer(held(), True, NOW_S)
    sent = steering.steer(held(till_s=NOW_S + 1.0), True, NOW_S + 0.2)
    assert (sent.linear_permille, sent.turn_permille) == (FULL, 0)


def test_a_press_waits_a_moment_for_its_first_advice():
    steering = working(press=6)
    assert steering.steer(held(), True, NOW_S).linear_permille == 0
    assert steering.steer(held(), True, NOW_S + 0.14).linear_permille == 0
    assert steering.steer(held(), True, NOW_S + 0.16).linear_permille == FULL


def test_a_press_that_is_over_is_steered_no_more():
    steering = working()
    steering.steer(held(), True, NOW_S)
    over = steering.steer(held(till_s=0.0), True, NOW_S + 0.01)
    assert (over.verb, over.turn_permille, over.ttl_deadline_s) == (codes.DRIVE, 0, 0.0)


def test_whatever_is_advised_and_pressed_stays_within_what_the_driver_asks():
    chance = random.Random(5)
    steering = Steering()
    verbs = {}  # of each press, on the wire
    now_s, edge, verb = NOW_S, 0, codes.FORWARD
    for _ in range(5000):
        now_s += chance.uniform(0.0, 0.1)
        if chance.random() < 0.2:
            edge = edge % 255 + 1
            verbs.pop(edge, None)
            verb = chance.choice((codes.FORWARD, codes.FORWARD, codes.LEFT, codes.DRIVE))
        if chance.random() < 0.5:
            wild = [chance.randint(-(10**6), 10**6) for _ in range(2)]
            press = chance.choice((edge, edge - 1, 0))
            steering.advised = Advised(press, *wild, True, now_s - chance.uniform(-1, 1))
        if chance.random() < 0.3:
            steering.ready_s = now_s - chance.uniform(-1, 2)
        ttl_s = now_s + chance.uniform(-0.1, 0.3)
        command = Command(verb, codes.CONTINUOUS, edge, codes.DRIVER, ttl_s)
        sent = steering.steer(command, chance.random() < 0.9, now_s)
        assert verbs.setdefault(edge, sent.verb) == sent.verb
        assert (sent.edge, sent.ttl_deadline_s) == (edge, ttl_s)
        if verb != codes.FORWARD:
            assert sent is command
        elif sent.verb == codes.DRIVE:
            assert 0 <= sent.linear_permille <= FULL
            assert abs(sent.turn_permille) <= MOST_TURN
            assert ttl_s > now_s or sent.turn_permille == 0


def test_it_is_shown_to_steer_while_it_does_and_a_moment_longer():
    steering = working()
    steering.steer(held(), True, NOW_S)
    assert [steering.steers(NOW_S + after_s) for after_s in (0.0, 0.5, 1.0)] == [True, True, False]
    steering.steer(STOP_COMMAND, True, NOW_S + 0.1)
    assert not steering.steers(NOW_S + 0.1)


def test_it_is_shown_to_wait_and_not_to_steer_until_it_goes_on_or_the_press_ends():
    for after, shown in (((7, 0, 0, False), True), ((7, 400, 0, True), False)):
        steering = working()
        steering.advised = Advised(7, 0, 0, False, NOW_S, waits=True)
        steering.steer(held(), True, NOW_S)
        assert (steering.steers(NOW_S), steering.waits(NOW_S)) == (False, True)
        steering.advised = Advised(*after, NOW_S + 0.1, waits=shown)
        steering.steer(held(), True, NOW_S + 0.1)
        assert (steering.steers(NOW_S + 0.1), steering.waits(NOW_S + 0.1)) == (not shown, shown)
        steering.steer(STOP_COMMAND, True, NOW_S + 0.15)
        assert not steering.waits(NOW_S + 0.15)


def test_waiting_for_another_press_is_not_shown():
    steering = working()
    steering.advised = Advised(6, 0, 0, True, NOW_S, waits=True)
    steering.steer(held(), True, NOW_S)
    assert not steering.waits(NOW_S)


def test_presses_of_two_drivers_do_not_share_advice():
    # The board's numbers go on; the page's own edges do not count.
    steering = working(press=7)
    first, second = held(7), held(8)
    assert steering.steer(first, True, NOW_S).turn_permille == 200
    assert steering.steer(second, True, NOW_S).turn_permille == 0
    for command, _ in itertools.product((second, held(9)), range(2)):
        assert steering.steer(command, True, NOW_S + 0.01).turn_permille == 0
