# Promises P4, P5, P6 and P13 on the whole firmware in lockstep virtual time: steps, obstacles,
# owners.

from gazeboard.core import limits
from gazelink import codes, messages
from gazesim.board_rig import NEUTRAL, Rig
from gazesim.small_host import clearance
from promiserig import armed, stays_still_until_pressed_anew
from promises import CORE, measured


def test_p4_a_forward_step_ends_by_itself():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    moved = rig.until(rig.neutral, 6000)
    measured(CORE, "P4", "a step forward", moved, rig.app.settings.step_forward_ms + 1)
    assert rig.app.safety.override == codes.NO_REASON  # it ended as asked
    stays_still_until_pressed_anew(rig)


def test_p4_a_turn_that_never_arrives_ends_at_its_limit():
    rig = Rig()
    rig.arm()
    rig.press(codes.LEFT, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    moved = rig.until(lambda: rig.app.motion.state == codes.STOPPED, 11000)
    assert rig.neutral()
    limit_ms = rig.app.settings.step_turn_limit_ms + 1
    measured(CORE, "P4", "a turn that never arrives", moved, limit_ms)
    assert rig.app.safety.override == codes.TIME_LIMIT


def test_p5_an_obstacle_on_the_path_stops_within_2_ms_with_the_reason():
    for verb, direction in (
        (codes.FORWARD, codes.DIR_FORWARD),
        (codes.BACKWARD, codes.DIR_BACKWARD),
        (codes.LEFT, codes.DIR_LEFT),
        (codes.RIGHT, codes.DIR_RIGHT),
    ):
        rig = Rig()
        rig.drive(verb)
        rig.blocked = 1 << direction
        rig.send(messages.CLEARANCE, clearance(rig.blocked, codes.REAL, 5))
        ms = rig.until(rig.neutral, 10)
        measured(CORE, "P5", "obstacle on the path, from the decoded frame", ms, 2)
        assert rig.app.safety.override == codes.OBSTACLE_FORWARD + direction
        rig.run(20)
        assert rig.state["override"] == codes.OBSTACLE_FORWARD + direction
        rig.blocked = 0
        rig.run(100)
        assert rig.neutral()  # free again: still the old press
        stays_still_until_pressed_anew(rig)


def test_p5_an_obstacle_beside_the_path_does_not_stop():
    rig = Rig()
    rig.drive(codes.FORWARD)
    rig.blocked = 15 & ~(1 << codes.DIR_FORWARD)
    for _ in range(200):
        rig.one_ms()
        assert not rig.neutral()


def test_p5_a_turns_own_correction_only_goes_where_it_is_free():
    rig = Rig()
    rig.arm()
    rig.press(codes.LEFT, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    rig.heading_q4 += 320  # thrown past the setpoint in small, believable pieces
    rig.app._imu._monitor.restart()
    rig.blocked = 1 << codes.DIR_RIGHT
    rig.run(25)  # told with the next frame
    for _ in range(300):
        rig.one_ms()
        assert rig.wipers()[1] >= NEUTRAL


def test_p6_old_obstacle_data_counts_as_blocked_within_300_ms_of_acquisition():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.lidar_alive = False
    ms = 5 + rig.until(rig.neutral, 400)  # sent with an age of 5 ms
    measured(CORE, "P6", "obstacle data stays away", ms, limits.CLEARANCE_OLD_MS)
    assert rig.app.safety.override == codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    rig.run(20)
    assert rig.state["decisions"] == 255
    rig.lidar_alive = True
    stays_still_until_pressed_anew(rig)


def test_p6_a_sender_whose_producer_died_does_not_keep_data_fresh():
    rig = Rig()
    rig.drive()
    rig.lidar_alive = False
    age = 5
    for _ in range(400):
        age += 1
        if rig.now_ms % 20 == 0:
            rig.send(messages.CLEARANCE, clearance(0, codes.REAL, age))
        rig.one_ms()
        if not rig.neutral():
            moved_at = age
    cause = "lidar's process dead, the host goes on sending"
    measured(CORE, "P6", cause, moved_at + 1, limits.CLEARANCE_OLD_MS)


def test_p13_only_the_owner_moves_and_anyones_stop_wins_in_one_tick():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    rig.command = rig.command[:3] + (codes.CARETAKER, 0, 0)
    rig.run(200)
    assert rig.neutral()
    assert rig.app.safety.override == codes.NOT_OWNER
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    rig.until(lambda: rig.now_ms % 20 == 5, 20)
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, codes.CARETAKER, 0, 0, 0, 1000, 0))
    ms = rig.until(rig.neutral, 5)  # decoded after one tick, obeyed in the next
    measured(CORE, "P13", "anyone's stop, from its last byte", ms, 2)


def test_p13_a_stop_and_a_held_command_in_the_same_millisecond_stop():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 5, 20)
    edge = rig.command[2]
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, codes.CARETAKER, 0, 0, 0, 1000, 0))
    rig.send(
        messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, edge, codes.DRIVER, 300, 0, 0, 1000, 0)
    )
    rig.until(rig.neutral, 2)
    stays_still_until_pressed_anew(rig)


def test_p13_hand_over_stops_first():
    rig = Rig()
    rig.drive()
    rig.give(codes.ARM, codes.CARETAKER)
    rig.until(rig.neutral, 25)
    assert rig.app.safety.owner == codes.CARETAKER
    assert armed(rig)
