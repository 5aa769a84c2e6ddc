"""Assist end to end: it steers the driver's held Vooruit, and nothing else, through the board."""

from __future__ import annotations

import json

from e2e.assisted import Assisted
from gazechair.assist.steering import OLD_S
from gazesim.random_rooms import door_task
from gazesim.rooms import Room

NEUTRAL = 170
HEARTBEAT_MS = 25
FULL = 50  # counts of linear at full, with the default settings
MOST_TURN = 51


def hold(chair: Assisted) -> None:
    chair.arm()
    chair.until(lambda: not chair.board.app.obstacles.blocked & 15, 700)
    chair.page.press("forward")
    chair.until(lambda: not chair.neutral(), 220)


def test_one_press_of_vooruit_passes_a_door_beside_the_way() -> None:
    room = door_task(0.95, 0.1, 0.0, 0.0, 1.0).room
    chair = Assisted(Room("door", room.walls, room.furniture, start=(room.start[0], 0.2, 0.0)))
    hold(chair)
    steered = False
    for _ in range(160):
        chair.run(100)
        steered |= chair.assist.shown(chair.now_s()) == [True, True, False]
        assert chair.page.shown["override"] == "none", chair.why()
        if chair.world.pose[0] > -0.9:  # its front is through
            break
    assert chair.world.pose[0] > -0.9
    assert chair.world.collisions == 0
    assert steered


def test_what_is_advised_counts_for_the_held_press_alone_and_within_its_bounds() -> None:
    chair = Assisted("open")
    chair.assist.runs = False
    advice = [500, 300]

    def child() -> None:
        if advice and chair.now_ms % 50 == 0:
            press = chair.assist._message.press
            words = [True, press, *advice, True, False, chair.now_s()]
            chair.assist._on_data(json.dumps(words).encode())

    chair.watchers.append(child)
    hold(chair)
    chair.until(lambda: chair.wipers()[1] > NEUTRAL, 400)
    assert NEUTRAL < chair.wipers()[0] < NEUTRAL + FULL
    # More than all: as fast as Vooruit itself, and no sharper than assist may turn.
    advice[:] = [9000, -9000]
    for _ in range(500):
        chair.one_ms()
        linear, turn = chair.wipers()
        assert NEUTRAL <= linear <= NEUTRAL + FULL
        assert abs(turn - NEUTRAL) <= MOST_TURN
    assert chair.wipers()[1] < NEUTRAL
    # Its process stands still: straight on, as the driver says.
    advice.clear()
    chair.until(lambda: chair.wipers()[1] == NEUTRAL, round(1000 * OLD_S) + 2 * HEARTBEAT_MS)
    # It creeps until its turn has ended: with one lidar no arc is seen.
    chair.until(lambda: chair.wipers()[0] == NEUTRAL + FULL, 2000)
    assert abs(chair.wipers()[1] - NEUTRAL) < 10
    assert chair.page.shown["override"] == "none"
    # It goes on while nothing is held.
    advice[:] = [1000, 300]
    chair.run(100)
    assert chair.wipers()[1] > NEUTRAL
    chair.page.release()
    chair.until(chair.neutral, 30)
    chair.stays_still(400)
    # Off in the middle of a press: the press goes on as Vooruit.
    chair.page.press("forward")
    chair.until(lambda: chair.wipers()[1] > NEUTRAL, 200)
    chair.assist.on = False
    chair.until(lambda: chair.wipers()[0] == NEUTRAL + FULL, 2 * HEARTBEAT_MS)
    chair.run(200)
    assert chair.page.shown["override"] == "none"
    # A press that began without assist stays without.
    chair.page.press("forward")
    chair.run(100)
    chair.assist.on = True
    chair.run(300)
    assert abs(chair.wipers()[1] - NEUTRAL) < 10
    assert chair.wipers()[0] == NEUTRAL + FULL
