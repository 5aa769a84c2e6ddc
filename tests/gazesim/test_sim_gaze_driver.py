"""The simulated gaze driver: reproducible by its seed; presses, releases, and never gives up."""

from dataclasses import replace

import pytest

from gazesim.gaze_driver import DWELL_S, GazeDriver, Seen

AHEAD = Seen(0.0, 0.0, 0.0, moves=False, turn_deg_s=20.0)
TICK_S = 0.025


def drive(driver, seen, seconds, from_s=0.0):
    """What the page keeps pressed in each tick."""
    return [driver.tick(from_s + k * TICK_S, seen) for k in range(round(seconds / TICK_S))]


def calm():
    """A seed whose first seconds bring no trouble."""
    return GazeDriver(1, ((5.0, 0.0),), helped=False)


def test_forward_takes_a_look_and_a_dwell():
    held = drive(calm(), AHEAD, 2.0)
    assert held[round(DWELL_S / TICK_S)] is None
    assert "forward" in held


def test_what_lies_aside_is_turned_to_first():
    driver = GazeDriver(1, ((0.0, 5.0),), helped=False)
    assert "left" in drive(driver, AHEAD, 3.0)
    assert driver.commands == 1


def test_a_press_that_the_chair_ended_takes_a_new_one():
    driver = calm()
    drive(driver, AHEAD, 2.0)
    assert driver.held == "forward"
    driver.ended()
    held = drive(driver, AHEAD, 3.0, 2.0)
    assert held[0] is None
    assert held[-1] == "forward"
    assert driver.commands == 2


def test_he_has_arrived_at_his_last_point():
    driver = GazeDriver(1, ((1.0, 0.0), (2.0, 0.0)), helped=False)
    drive(driver, AHEAD, 1.0)
    drive(driver, replace(AHEAD, x_m=0.95), 1.0, 1.0)
    assert not driver.arrived
    drive(driver, replace(AHEAD, x_m=1.9), 1.0, 2.0)
    assert driver.arrived
    assert driver.held is None or drive(driver, replace(AHEAD, x_m=1.9), 1.0, 3.0)[-1] is None


@pytest.mark.parametrize("helped", [False, True])
def test_the_same_seed_has_the_same_luck(helped):
    both = [GazeDriver(7, ((50.0, 0.0),), helped) for _ in range(2)]
    moving = replace(AHEAD, moves=True)
    held = [drive(driver, moving if k else AHEAD, 60.0) for k, driver in enumerate(both)]
    assert drive(GazeDriver(7, ((50.0, 0.0),), helped), AHEAD, 60.0) == held[0]
    assert held[0].count("forward") > 0


def test_dropouts_and_spasms_end_presses():
    driver = GazeDriver(3, ((50.0, 0.0),), helped=True)
    for k in range(round(300.0 / TICK_S)):
        moves = driver.held is not None
        driver.tick(k * TICK_S, replace(AHEAD, moves=moves))
    assert 3 <= driver.commands <= 40


@pytest.mark.parametrize(("waits", "least_s", "most_s"), [(False, 0.9, 1.1), (True, 14.9, 15.1)])
def test_they_hold_on_for_a_while_where_the_page_says_why_nothing_moves(waits, least_s, most_s):
    driver = GazeDriver(6, ((50.0, 0.0),), helped=True)
    stands = replace(AHEAD, waits=waits)
    held = drive(driver, stands, 20.0)
    begun = held.index("forward")
    assert least_s <= held.index(None, begun) * TICK_S - begun * TICK_S <= most_s


def test_after_three_presses_ended_in_one_place_they_back_away():
    driver = calm()
    now_s, held = 0.0, []
    for _ in range(3):
        for _ in range(200):
            held.append(driver.tick(now_s, AHEAD))
            now_s += TICK_S
            if driver.held == "forward":
                break
        assert "backward" not in held
        driver.ended()
    moves = replace(AHEAD, moves=True)
    backed = drive(driver, AHEAD, 2.0, now_s) + drive(driver, moves, 4.0, now_s + 2.0)
    assert "forward" not in backed
    assert "backward" in backed
    assert backed[-1] is None
    assert "forward" in drive(driver, AHEAD, 4.0, now_s + 6.0)


@pytest.mark.parametrize("helped", [False, True])
def test_after_a_turn_that_the_chair_ended_they_go_past_what_stopped_it(helped):
    driver = GazeDriver(1, ((9.0, 5.0),), helped)  # 29 degrees to the left
    drive(driver, AHEAD, 1.2)
    assert driver.held == "left"
    driver.ended()
    until = drive(driver, AHEAD, 2.1, 1.2)
    assert until[-1] == "forward"
    assert driver.commands == 2
    on = replace(AHEAD, x_m=0.4, moves=True)
    assert set(drive(driver, on, 0.9, 3.3)) == {"forward"}
    gone = replace(AHEAD, x_m=1.5, y_m=-2.0)  # 43 degrees, and far enough past it
    assert "left" in drive(driver, gone, 3.0, 4.2)


@pytest.mark.parametrize("looked_ticks", range(1, 30))
def test_who_rolls_to_the_goal_while_they_look_at_a_turn_presses_nothing(looked_ticks):
    driver = GazeDriver(1, ((0.0, 5.0),), helped=False)
    drive(driver, AHEAD, looked_ticks * TICK_S)
    there = replace(AHEAD, y_m=5.0)
    assert drive(driver, there, 1.0, looked_ticks * TICK_S)[-1] is None
    assert driver.arrived
