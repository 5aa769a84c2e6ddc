# Where an auto motion may go, and how fast (P19): never where no lidar sees, never by a bypass,
# never above its own speed. The footprint's decisions are those of any motion.

from gazeboard.core import limits
from gazeboard.core.stopping import Stopping
from gazeboard.io.settings import Settings
from gazelink import arcs, codes
from gazelink.messages import CLEAR_FAR
from gazesim.core_rig import Core
from obstaclerig import Eyes, Stick

NEAR = 1  # mm or sixteenths: within every margin
WAYS = ((400, 0), (-400, 0), (0, 400), (0, -400))


def auto_eyes(linear=0, turn=0):
    stick = Stick(linear, turn)
    stick.i.mode = codes.AUTO
    return stick


def test_a_direction_that_is_not_seen_is_blocked_in_the_same_tick():
    for direction in range(4):
        eyes = Eyes()
        eyes.i.clearance_unseen = 1 << direction
        assert eyes.o.auto_blocked(eyes.i) == 1 << direction
        eyes.run(400)
        assert eyes.decision(direction) == codes.SLOW  # a person may creep there
        assert eyes.o.auto_blocked(eyes.i) == 1 << direction
    eyes.i.clearance_unseen = 0xF0
    assert eyes.o.auto_blocked(eyes.i) == eyes.o.blocked == 0


def test_what_is_blocked_for_a_person_is_blocked_for_it():
    for direction in range(4):
        eyes = Eyes()
        assert eyes.o.auto_blocked(eyes.i) == eyes.o.blocked == 0
        eyes.set(NEAR, (direction,))
        eyes.run(40)
        assert eyes.o.auto_blocked(eyes.i) == eyes.o.blocked == 1 << direction


def test_a_bypass_does_not_help_it():
    for direction in range(4):
        eyes = Eyes()
        eyes.set(NEAR, (direction,))
        eyes.run(40)
        eyes.hold_bypass(1)
        eyes.run(40)
        assert eyes.o.bypass.left_ms > 0
        assert eyes.o.blocked == 0
        assert eyes.decision(direction) == codes.SLOW
        assert eyes.o.auto_blocked(eyes.i) == 1 << direction
        # Nothing is blocked for longer than it is.
        eyes.set(CLEAR_FAR)
        for _ in range(40):
            eyes.hold_bypass(1)
            eyes.run(20)
        assert eyes.o.bypass.left_ms > 0
        assert eyes.o.auto_blocked(eyes.i) == 0
        # What comes near while it lasts, and until every direction is decided without it.
        eyes.set(NEAR)
        eyes.frame()
        eyes.tick()
        assert eyes.o.auto_blocked(eyes.i) == 15
        eyes.run(40)
        eyes.i.bypass_ttl_ms = 0
        eyes.i.bypass_count += 1
        for _ in range(40):
            eyes.tick()
            assert eyes.o.auto_blocked(eyes.i) == 15
        assert eyes.o.blocked == 15
        assert eyes.o._bypassed == 0


def test_where_a_person_may_creep_a_bypass_blocks_nothing_for_it():
    eyes = Eyes()
    for direction in range(4):
        eyes.set(eyes.stopping(direction).begin[0], (direction,))
    eyes.run(40)
    assert eyes.o.blocked == 0
    eyes.hold_bypass(1)
    eyes.run(40)
    assert eyes.o.bypass.left_ms > 0
    assert eyes.o.auto_blocked(eyes.i) == 0


def test_what_comes_near_is_decided_in_its_tick_and_leaves_the_others_as_they_are():
    for direction in range(4):
        eyes = Eyes()
        for at in range(4):
            eyes.set(eyes.stopping(at).begin[0], (at,))
        eyes.run(40)
        assert [eyes.decision(at) for at in range(4)] == [codes.SLOW] * 4
        eyes.frames = False
        eyes.i.clearance_blocked = 1 << direction
        eyes.frame()
        eyes.o._look(eyes.i)
        wanted = [codes.SLOW] * 4
        wanted[direction] = codes.BLOCKED
        assert [eyes.decision(at) for at in range(4)] == wanted
        assert eyes.o.auto_caps[direction] == eyes.o.caps[direction] == 0
        assert min(eyes.o.auto_caps[:direction] + eyes.o.auto_caps[direction + 1 :]) > 0


# Both axes where a quadrant is not seen, or blocked: another command, so it is judged at once.
def test_an_arc_that_is_not_seen_is_blocked_for_it_only():
    for quadrant in range(4):
        linear = 400 if quadrant & 1 == 0 else -400
        turn = 400 if quadrant & 2 == 0 else -400
        stick = Stick(linear, turn)
        stick.i.clearance_arc_views = 16 << quadrant
        stick.run(400)
        assert not stick.blocked()
        stick.i.mode = codes.AUTO
        stick.tick()
        assert stick.blocked()
        stick.i.mode = codes.CONTINUOUS
        stick.run(400)
        assert not stick.blocked()
        # Another quadrant is another way.
        stick.i.clearance_arc_views = 240 & ~(16 << quadrant)
        stick.i.mode = codes.AUTO
        stick.run(400)
        assert not stick.blocked()
        # What comes unseen while it drives is blocked with that clearance.
        stick.frames = False
        stick.run(9)
        stick.i.clearance_arc_views = 16 << quadrant
        stick.frame()
        stick.tick()
        assert stick.blocked()


def test_a_bypass_does_not_help_its_arcs():
    stick = Stick(400, 400)
    stick.rows(0, arcs.SIZE, 0)
    stick.run(40)
    stick.hold_bypass(1)
    stick.run(40)
    assert not stick.blocked()
    stick.i.mode = codes.AUTO
    stick.tick()
    assert stick.blocked()
    stick.hold_bypass(1)
    stick.run(100)
    assert stick.o.bypass.left_ms > 0
    assert stick.blocked()
    # Nor while it drives: a clearance that is near blocks in its tick.
    stick = auto_eyes(400, 400)
    stick.run(400)
    stick.hold_bypass(1)
    stick.run(40)
    assert not stick.blocked()
    stick.frames = False
    stick.run(9)
    stick.rows(0, arcs.SIZE, 0)
    stick.frame()
    stick.tick()
    assert stick.blocked()


def test_single_axes_need_no_arc():
    for linear, turn in WAYS:
        stick = auto_eyes(linear, turn)
        stick.i.clearance_arc_views = 0xF0
        stick.linear = stick.turn = 0
        stick.run(100)
        assert not stick.blocked(), (linear, turn)


def test_another_mode_is_another_command():
    stick = Stick(400, 400)
    stick.tick()
    assert stick.o.arcs.changed(stick.i) == 0
    stick.i.mode = codes.AUTO
    assert stick.o.arcs.changed(stick.i) == 1
    assert stick.o.arcs.changed(stick.i) == 0
    stick.push(0, 0)
    stick.i.mode = codes.AUTO
    stick.tick()
    assert stick.o.arcs.changed(stick.i) == 0
    assert not stick.blocked()
    # A verb's mode is none.
    stick.push(0, 0, codes.FORWARD)
    stick.tick()
    stick.i.mode = codes.STEP
    assert stick.o.arcs.changed(stick.i) == 0


# Most output that keeps forward, or the outermost point of a turn, at 350 mm/s.
def test_its_output_keeps_to_its_speed():
    for full, turns in ((556, False), (361, False), (910, True), (273, True)):
        most = 350 * 917 // limits.OUTERMOST_MM if turns else 350
        permille = min(1000, most * 1000 // full)
        stopping = Stopping(Settings(), codes.DIR_LEFT if turns else codes.DIR_FORWARD, False)
        stopping.full = full
        assert stopping._permille(limits.AUTO_MM_S) == permille
    settings = Settings()
    for mm_s in (250, 300, 350):
        settings.auto_mm_s = mm_s
        for direction in range(4):
            for trusted in (False, True):
                s = Stopping(settings, direction, trusted)
                units = mm_s * 917 // 750 if direction >= codes.DIR_LEFT else mm_s
                assert s.auto == min(1000, units * 1000 // s.full)
                assert s.speed(s.auto) <= max(units, 0) + 1


def test_its_caps_are_those_of_the_chair_that_is_believed_in():
    eyes = Eyes()
    for trusted in (False, True):
        eyes.trusted = trusted
        eyes.run(40)
        for at in range(4):
            assert eyes.o.auto_caps[at] == min(eyes.stopping(at).auto, eyes.o.caps[at])
        assert eyes.o.auto_caps[0] < eyes.o.caps[0]
    for sluggish in range(2):
        for _ in range(16):
            eyes.o.step(eyes.i, 0, 0, True, False, sluggish == 1)
        for at in range(4):
            known = 4 if sluggish and at >= codes.DIR_LEFT else 0
            assert eyes.o.auto_caps[at] == eyes.o._stopping[at + known].auto


def test_what_obstacles_leave_is_below_its_caps():
    for direction in range(4):
        eyes = Eyes()
        s = eyes.stopping(direction)
        eyes.set(s.begin[0], (direction,))
        eyes.run(40)
        assert eyes.o.auto_caps[direction] == eyes.o.caps[direction] == s.permille[0]
        eyes.set(NEAR, (direction,))
        eyes.run(40)
        assert eyes.o.auto_caps[direction] == 0


def test_before_anything_was_seen_all_is_blocked_for_it():
    eyes = Eyes(clear=False)
    assert eyes.o.auto_blocked(eyes.i) & 15 == 15
    assert eyes.o.auto_caps == [0] * 4


def test_in_the_tick_it_drives_no_faster_than_its_caps():
    for linear, turn in ((1000, 0), (-1000, 0), (0, 1000), (0, -1000), (1000, 1000), (-1000, 700)):
        core = Core()
        core.settings.linear_permille = core.settings.turn_permille = 1000
        core.obstacles.configure(core.settings)
        core.arm()
        core.auto(linear, turn)
        for _ in range(300):
            core.tick()
            assert core.moving(), core.why()
            caps = core.obstacles.auto_caps
            assert abs(core.motion.linear_permille) <= caps[0 if linear > 0 else 1]
            assert abs(core.motion.turn_permille) <= caps[2 if turn > 0 else 3]
        core.press(codes.DRIVE)
        core.tick()
        assert abs(core.motion.linear_permille) + abs(core.motion.turn_permille) > 999


def test_in_the_tick_it_does_not_begin_beside_a_bypass_nor_unseen():
    core = Core()
    core.arm()
    core.i.clearance_blocked = 1
    core.see()
    core.i.bypass_number = 1
    for _ in range(100):
        core.i.bypass_ttl_ms = 300
        core.i.bypass_count += 1
        core.tick()
    assert core.obstacles.blocked == 0
    core.auto()
    core.tick()
    assert core.safety.override == codes.OBSTACLE_FORWARD, core.why()
    assert not core.moving()
    core = Core()
    core.i.clearance_unseen = 1
    core.arm()
    core.auto()
    core.tick()
    assert core.safety.override == codes.OBSTACLE_FORWARD, core.why()
    core.i.linear_permille = 0
    core.auto(0, 300)
    core.tick()
    assert core.moving()
