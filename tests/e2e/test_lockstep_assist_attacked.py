"""Assist attacked while it steers: whatever fails, it moves no more than a held Vooruit may."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from e2e.assisted import Assisted
from e2e.test_lockstep_assist import FULL, MOST_TURN, NEUTRAL, hold
from gazechair.board.zone import NOT_KNOWN
from gazesim.random_rooms import door_task
from gazesim.rooms import Person, Room

RELEASED_MS = 60  # after letting go: nothing moves
HOLDING = 10  # counts with which the board holds the heading of a press straight on


def beside_a_door(*people: Person) -> Assisted:
    """It turns on the spot to a door beside the way; `people` are there, too."""
    room = door_task(0.95, 0.1, 0.0, 0.0, 1.0).room
    start = (room.start[0], 0.3, 0.0)
    chair = Assisted(Room("door", room.walls, room.furniture, people=people, start=start))
    chair.watchers.append(lambda: judge(chair))
    hold(chair)
    chair.until(lambda: turns(chair), 3000)
    return chair


def turns(chair: Assisted) -> bool:
    return abs(chair.world.chair.yaw_rate_deg_s) > 2.0


def judge(chair: Assisted) -> None:
    """Vooruit is all that is ever held: no more than that, and nothing else."""
    linear, turn = chair.wipers()
    assert NEUTRAL <= linear <= NEUTRAL + FULL, chair.why()
    assert abs(turn - NEUTRAL) <= MOST_TURN, chair.why()
    assert chair.world.collisions == 0, chair.why()
    if chair.now_ms - chair.page.proved_ms > RELEASED_MS:
        assert chair.harmless(), chair.why()


def fault(name: str) -> Callable[[Assisted], None]:
    def attack(chair: Assisted) -> None:
        chair.world.faults.inject(name)
        chair.run(1200)
        chair.world.faults.clear(name)

    attack.__name__ = name
    return attack


def its_process_hangs_and_goes_on(chair: Assisted) -> None:
    chair.assist.runs = False
    chair.run(900)
    chair.assist.runs = True


def its_process_is_started_again(chair: Assisted) -> None:
    chair.assist.runs = False
    chair.run(400)
    chair.assist.starts_again()


def its_records_come_late_twice_and_in_any_order(chair: Assisted) -> None:
    chance = random.Random(3)
    assist = chair.assist
    for _ in range(60):
        chair.run(chance.randrange(30))
        for record in chance.sample(assist.sent[-8:], 3):
            assist._on_data(record)


def stop_and_vooruit_within_50_ms(chair: Assisted) -> None:
    for pause_ms in (0, 1, 20, 45):
        chair.page.release()
        chair.run(pause_ms)
        chair.page.press("forward")
        chair.run(300)


def another_driver_presses(chair: Assisted) -> None:
    other = chair.another_page()
    other.press("forward")
    chair.run(600)
    other.release()


def it_is_off_and_on_again(chair: Assisted) -> None:
    chair.assist.on = False
    chair.run(300)
    chair.assist.on = True


def the_boards_numbers_are_lost(chair: Assisted) -> None:
    zone = chair.assist._message.zone
    chair.assist.zone(NOT_KNOWN)
    chair.run(400)
    chair.assist.zone(zone)


ATTACKS = [
    fault("lidar_stall"),
    fault("lidar_covered"),
    fault("lidar_frozen"),
    fault("imu_nak"),
    fault("imu_freeze"),
    its_process_hangs_and_goes_on,
    its_process_is_started_again,
    its_records_come_late_twice_and_in_any_order,
    stop_and_vooruit_within_50_ms,
    another_driver_presses,
    it_is_off_and_on_again,
    the_boards_numbers_are_lost,
]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_whatever_fails_while_it_turns_nothing_moves_more_than_is_held(
    attack: Callable[[Assisted], None],
) -> None:
    chair = beside_a_door()
    attack(chair)
    chair.run(800)
    chair.page.release()
    chair.run(RELEASED_MS)
    chair.stays_still(400)


def test_a_press_in_which_its_process_was_started_again_turns_no_more() -> None:
    chair = beside_a_door()
    its_process_is_started_again(chair)
    chair.until(lambda: not turns(chair), 1500)
    for _ in range(1500):
        chair.one_ms()
        assert abs(chair.wipers()[1] - NEUTRAL) <= HOLDING, chair.why()
    chair.page.press("forward")
    chair.until(lambda: chair.assist._steering.steers(chair.now_s()), 1000)


def test_a_person_who_steps_into_the_door_is_not_touched() -> None:
    chair = beside_a_door(Person(((0.3, 2.0), (0.1, 0.0)), 0.8))
    chair.run(7000)
