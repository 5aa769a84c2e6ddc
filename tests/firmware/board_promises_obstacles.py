# Promises P5 and P14 by distances, and the bypass, on the whole firmware in lockstep virtual time.

from gazeboard.core import limits
from gazelink import arcs, codes, messages
from gazesim.board_rig import NEUTRAL, Rig
from gazesim.small_host import FAR
from promiserig import stays_still_until_pressed_anew
from promises import CORE, kept, measured

VERBS = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT)


def moving(rig, direction):
    # The count beside neutral, towards the direction.
    linear, turn = rig.wipers()
    return (linear - NEUTRAL, NEUTRAL - linear, turn - NEUTRAL, NEUTRAL - turn)[direction]


def test_p5_a_person_steps_into_the_path():
    # Nearer than the chair needs to stop from its speed, though far from touching.
    for direction in range(4):
        rig = Rig()
        rig.drive(VERBS[direction])
        rig.run(300)
        stop = rig.app.obstacles._ways[direction].stop
        assert stop > (250, 250, 200, 200)[direction]
        rig.until(lambda: rig.now_ms % 20 == 5, 20)
        rig.distances[direction] = stop - 1
        rig.see()
        ms = rig.until(rig.neutral, 10)
        cause = "a person steps into the path: nearer than it takes to stop"
        measured(CORE, "P5", cause, ms, 2)
        assert rig.app.safety.override == codes.OBSTACLE_FORWARD + direction
        rig.run(40)
        assert rig.state["decisions"] >> (2 * direction) & 3 == codes.BLOCKED
        rig.distances[direction] = FAR
        rig.run(600)
        assert rig.neutral()  # free again: still the old press
        stays_still_until_pressed_anew(rig)


def test_p5_slows_before_an_obstacle_and_resumes_by_itself():
    for direction in range(4):
        rig = Rig()
        rig.drive(VERBS[direction])
        rig.run(100)
        fast = moving(rig, direction)
        rig.distances[direction] = (500, 500, 700, 700)[direction]
        rig.run(60)
        slow = moving(rig, direction)
        assert 0 < slow < fast
        assert rig.app.safety.override == codes.NO_REASON
        assert rig.state["decisions"] >> (2 * direction) & 3 == codes.SLOW
        rig.distances[direction] = FAR
        rig.run(limits.CLEAR_MS + 60)
        assert moving(rig, direction) == fast  # the same press
    kept(CORE, "P14", "slowed down only: goes on by itself")


def test_p5_a_way_out_is_left():
    rig = Rig()
    rig.drive()
    rig.distances[codes.DIR_FORWARD] = 50
    rig.until(rig.neutral, 60)
    for verb in (codes.BACKWARD, codes.LEFT, codes.RIGHT):
        rig.press(verb)
        rig.run(60)
        assert moving(rig, verb - codes.FORWARD) > 0, rig.why()
        rig.release()
        rig.run(1500)
    rig.press(codes.FORWARD)
    rig.run(60)
    assert rig.neutral()
    assert rig.app.safety.override == codes.OBSTACLE_FORWARD


def test_p5_an_arc_never_seen_is_crept_into():
    rig = Rig()
    rig.unseen = 1 << codes.DIR_BACKWARD
    rig.drive(codes.BACKWARD)
    rig.run(100)
    assert 0 < moving(rig, codes.DIR_BACKWARD) <= 84 * 254 // 1000 + 1  # 120 of 472 mm/s


def test_p5_a_proportional_command_needs_both_its_ways():
    for linear, turn, near in ((300, 300, 0), (300, 300, 2), (-300, -300, 1), (-300, -300, 3)):
        rig = Rig()
        rig.arm()
        rig.press(codes.DRIVE, codes.CONTINUOUS, linear, turn)
        rig.until(lambda rig=rig: not rig.neutral(), 60)
        rig.distances[near] = 60
        rig.until(rig.neutral, 40)
        assert rig.app.safety.override == codes.OBSTACLE_FORWARD + near


def test_p5_a_post_beside_the_way_of_an_arc():
    # Neither straight on nor by turning on the spot is anything near: only by doing both.
    for quadrant, linear, turn in ((0, 300, 300), (1, -300, 300), (2, 300, -300), (3, -300, -300)):
        rig = Rig()
        rig.arm()
        rig.press(codes.DRIVE, codes.CONTINUOUS, linear, turn)
        rig.until(lambda rig=rig: not rig.neutral(), 60)
        rig.run(300)
        rig.until(lambda rig=rig: rig.now_ms % 20 == 5, 20)
        for row in range(arcs.ROWS):
            rig.ways[quadrant * arcs.ROWS + row] = 15
        rig.see()
        ms = rig.until(rig.neutral, 10)
        measured(
            CORE, "P5", "a post beside the way, met only by driving and turning at once", ms, 2
        )
        side = codes.OBSTACLE_LEFT if turn > 0 else codes.OBSTACLE_RIGHT
        assert rig.app.safety.override == side
        rig.ways[:] = arcs.ALL_FAR
        stays_still_until_pressed_anew(rig)


# With the bypass of that number held, a new press moves the chair.
def creep_past(rig, number):
    rig.bypass = number
    rig.run(40)
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)


def test_p5_bypass_creeps_for_at_most_20_s():
    rig = Rig()
    rig.drive()
    rig.distances[codes.DIR_FORWARD] = 40
    rig.until(rig.neutral, 60)
    rig.run(2500)  # until it stands
    creep_past(rig, 1)
    creep = moving(rig, codes.DIR_FORWARD)
    assert 0 < creep <= 84 * 215 // 1000 + 1
    assert 19000 < rig.app.bypass_ms() <= limits.BYPASS_MAX_MS
    ms = rig.until(rig.neutral, 21000)
    measured(CORE, "P5", "bypass held on and on", ms, limits.BYPASS_MAX_MS)
    assert rig.app.safety.override == codes.OBSTACLE_FORWARD
    assert rig.app.bypass_ms() == 0
    rig.press(codes.FORWARD)
    rig.run(500)
    assert rig.neutral()  # the button is still held: its press is over
    rig.bypass = 2
    rig.run(60)
    assert rig.neutral()  # the driver's is, too
    rig.press(codes.FORWARD)
    rig.run(500)
    assert rig.neutral()  # half as long as it lasted nothing passes, whatever is pressed
    rig.bypass = 0
    rig.release()
    rig.run(limits.BYPASS_MAX_MS // 2)
    creep_past(rig, 3)


def test_p5_bypass_ends_with_the_button_and_with_its_frames():
    for say_so in (True, False):
        rig = Rig()
        rig.arm()
        rig.distances[codes.DIR_FORWARD] = 40
        creep_past(rig, 1)
        rig.bypass = 0
        if say_so:
            rig.send(messages.BYPASS, (1, 0))
        ms = rig.until(rig.neutral, 400)
        cause = "bypass let go" if say_so else "bypass no longer said"
        measured(CORE, "P5", cause, ms, 40 if say_so else 300)
        stays_still_until_told(rig)


def stays_still_until_told(rig):
    rig.run(300)
    assert rig.neutral()
    assert rig.app.safety.override == codes.OBSTACLE_FORWARD


def test_p6_a_bypass_does_not_pass_old_data():
    rig = Rig()
    rig.arm()
    rig.distances[codes.DIR_FORWARD] = 40
    creep_past(rig, 1)
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.lidar_alive = False
    ms = 5 + rig.until(rig.neutral, 400)
    measured(CORE, "P6", "obstacle data stays away during a bypass", ms, limits.CLEARANCE_OLD_MS)


def test_p12_a_bypass_of_before_never_comes_back():
    rig = Rig()
    rig.arm()
    rig.distances[codes.DIR_FORWARD] = 40
    for number in (5, 6):
        rig.bypass = number
        rig.run(60)
        assert rig.app.bypass_ms() > 0
    rig.bypass = 5
    rig.run(400)
    assert rig.app.bypass_ms() == 0
    rig.give(codes.DISARM)
    rig.bypass = 7
    rig.run(100)
    assert rig.app.bypass_ms() == 0
    rig.arm()
    rig.run(100)
    assert rig.app.bypass_ms() == 0  # it was pressed before
    kept(CORE, "P12", "an old press of the bypass")


def test_without_a_relay_the_chair_is_slow():
    rig = Rig()
    rig.relay_works = False  # nothing moves where none is fitted: that would be a fault
    rig.app.settings.relay_fitted = 0
    rig.app._apply_settings()
    rig.drive()
    rig.run(600)
    assert 0 < moving(rig, codes.DIR_FORWARD) <= 84 * 360 // 1000  # 200 of 556 mm/s
    rig.release()
    rig.run(2500)
    rig.press(codes.LEFT)
    rig.run(600)
    assert 0 < moving(rig, codes.DIR_LEFT) <= 84 * 307 // 1000 + 1
