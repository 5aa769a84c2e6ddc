# An auto motion in the core: its planner's life, supervision, what ends it for good (P17, P18,
# P20).

from autorig import going, spent
from gazeboard.core import ages, limits
from gazeboard.core.auto import Auto
from gazelink import codes
from gazesim.core_rig import Core, refused

MARGIN_MS = limits.MARGIN_MS
SUPERVISION_MS = 3000  # the setting
LIMIT_MS = 600_000


def test_it_moves_as_its_planner_says_and_stands_when_it_says_so():
    core = going(400)
    assert (core.motion.linear_permille, core.motion.turn_permille) == (400, 0)
    assert core.motion.state == codes.DRIVING
    core.i.linear_permille, core.i.turn_permille = 0, -300
    core.tick()
    assert (core.motion.linear_permille, core.motion.turn_permille) == (0, -300)
    core.i.turn_permille = 0
    for _ in range(11_000):  # longer than an obstacle may overrule it
        core.tick()
        assert not core.moving()
    assert core.safety.edge == core.i.edge
    core.i.linear_permille = 300
    core.tick()
    assert core.motion.linear_permille == 300


def test_only_a_drive_may_be_auto():
    for verb in (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, 6):
        core = Core()
        core.arm()
        core.auto()
        core.i.verb = verb
        core.tick()
        assert refused(core, codes.BAD_COMMAND)
    core = going()
    core.i.verb = codes.FORWARD
    core.tick()
    core.i.verb = codes.DRIVE
    assert spent(core, codes.BAD_COMMAND)


def test_without_settings_nothing_is_permitted():
    core = Core()
    core.safety.auto = Auto(core.safety.ages.words)
    core.safety.ages.words[ages.SUPERVISION_MOST] = 0
    core.arm()
    core.auto()
    core.tick()
    assert refused(core, codes.SUPERVISION_LOST)
    core.safety.ages.words[ages.SUPERVISION_MOST] = 3000
    core.auto()
    core.tick()
    assert refused(core, codes.AUTO_LIMIT)


# How many ticks it moves on, from now.
def lasts(core, most=11_000):
    ticks = 0
    while True:
        core.tick()
        if not core.moving():
            return ticks
        ticks += 1
        assert ticks < most, core.why()


def test_the_planners_value_lives_150_ms_at_most():
    for ttl_ms, lasts_ms in ((150, 148), (151, 148), (300, 148), (65535, 148), (60, 58), (4, 2)):
        core = going()
        core.hold_ms = 0
        core.command(ttl_ms)
        assert lasts(core) == lasts_ms, ttl_ms
        assert spent(core, codes.COMMAND_EXPIRED)
    core = Core()
    core.arm()
    core.auto(hold_ms=MARGIN_MS)
    core.tick()
    assert refused(core, codes.COMMAND_EXPIRED)


def test_a_held_drive_lives_as_long_as_before():
    core = Core()
    core.arm()
    core.i.linear_permille = 500
    core.press(codes.DRIVE, hold_ms=0)
    assert lasts(core) == limits.COMMAND_TTL_MS - MARGIN_MS


def test_supervision_is_counted_down_from_when_it_was_proven():
    for setting_ms in (500, 3000, 10000):
        for age_ms in (0, 1, 100, setting_ms - MARGIN_MS - 1):
            core = Core()
            core.settings.supervision_ms = setting_ms
            core.safety.auto.configure(core.settings)
            core.arm()
            core.auto()
            core.watched = False
            core.watch_on(age_ms)
            assert lasts(core) == setting_ms - MARGIN_MS - age_ms, (setting_ms, age_ms)
            assert spent(core, codes.SUPERVISION_LOST)


def test_an_old_supervision_is_none():
    for age_ms in (SUPERVISION_MS - MARGIN_MS, SUPERVISION_MS, 60000):
        core = Core()
        core.arm()
        core.auto()
        core.watched = False
        core.watch_on(age_ms)
        core.tick()
        assert refused(core, codes.SUPERVISION_LOST)
        # What comes later helps the next press only.
        core.watched = True
        for _ in range(20):
            core.tick()
            assert not core.moving()


def test_a_new_supervision_replaces_the_old_one_whatever_it_says():
    core = going()
    core.watched = False
    core.watch_on(0)
    core.tick()
    core.watch_on(SUPERVISION_MS - MARGIN_MS - 5)
    assert lasts(core) == 5
    core = going()
    core.watched = False
    for _ in range(4):
        core.watch_on(1000)
        core.run(1500)
        assert core.moving()
    core.watch_on(60000)  # nobody watches any more
    core.tick()
    assert spent(core, codes.SUPERVISION_LOST)


def test_the_supervision_of_another_press_is_none():
    core = going()
    core.watched = False
    core.i.supervision_edge = core.i.edge - 1
    core.tick()
    assert spent(core, codes.SUPERVISION_LOST)
    core = going()
    core.watched = False
    core.i.supervision_edge = core.i.edge + 1
    core.tick()
    assert spent(core, codes.SUPERVISION_LOST)
    core = Core()
    core.arm()
    core.auto()
    core.tick()
    core.watched = False
    core.auto()  # the next press, before anybody is seen to watch that one
    core.watched = False
    core.tick()
    assert refused(core, codes.SUPERVISION_LOST)


def test_missed_ticks_count_in_what_is_left():
    core = going()
    core.watched = False
    core.watch_on(0)
    core.tick()
    core.safety.missed_ms = 2000
    core.hold_ms = 60000
    core.tick()
    assert not core.moving()  # the command's life passed, too
    core = going()
    core.watched = False
    core.watch_on(0)
    core.tick()
    words = core.safety.ages.words
    left_ms, limit_ms = words[ages.SUPERVISED], core.safety.auto.left_ms
    core.safety.missed_ms = 17
    core.tick()
    assert words[ages.SUPERVISED] == left_ms - 18
    assert core.safety.auto.left_ms == limit_ms - 18
    assert core.safety.missed_ms == 0
    core.safety.missed_ms = 100_000
    core.tick()
    assert words[ages.SUPERVISED] == 0


def test_supervision_goes_on_while_nothing_moves():
    core = Core()
    core.arm()
    core.i.supervision_edge = 1
    core.watch_on(0)
    core.run(100)
    words = core.safety.ages.words
    assert words[ages.SUPERVISED] == SUPERVISION_MS - MARGIN_MS - 99


def test_any_other_press_ends_it():
    # A bypass's number, a command of another number or person: each counts as one press.
    for presses in (1, 2, 0xFFFF):
        core = going()
        core.i.press_count = (core.i.press_count + presses) & 0xFFFF
        core.tick()
        assert spent(core, codes.ANOTHER_PRESS)
    for verb, mode in ((codes.FORWARD, codes.CONTINUOUS), (codes.LEFT, codes.STEP)):
        core = going()
        old = core.i.edge
        core.press(verb, mode)
        core.tick()
        assert core.moving()
        assert (core.safety.edge, core.safety.spent_edge) == (core.i.edge, old)
        core.release()
        core.tick()
        core.i.verb, core.i.mode, core.i.edge = codes.DRIVE, codes.AUTO, old
        core.i.press_count += 1
        core.hold_ms = 150
        for _ in range(20):
            core.tick()
            assert not core.moving()


def test_it_does_not_begin_beside_another_press():
    core = Core()
    core.arm()
    core.auto()
    core.i.press_count += 1
    core.tick()
    assert refused(core, codes.ANOTHER_PRESS)
    # Nor without one of its own.
    core = Core()
    core.arm()
    core.auto()
    core.i.press_count = core.safety.ages.words[ages.PRESS_COUNT]
    core.tick()
    assert refused(core, codes.ANOTHER_PRESS)


def test_the_press_count_wraps():
    core = Core()
    core.arm()
    core.i.press_count = 0xFFFF
    core.tick()
    core.auto()
    core.tick()
    assert core.i.press_count == 0
    assert core.moving(), core.why()


def test_a_stop_by_anyone_and_a_take_over_end_it():
    core = going()
    core.stop()
    core.tick()
    assert not core.moving()
    assert core.safety.edge == 0
    core.run(20)
    assert not core.moving()
    core.auto()
    core.tick()
    assert core.moving()
    core = going()
    core.order(codes.ARM, codes.CARETAKER)
    core.tick()
    assert not core.moving()
    assert core.safety.override == codes.NOT_OWNER
    core = going()
    core.order(codes.DISARM)
    core.tick()
    assert not core.moving()
    assert not core.armed()


def test_it_ends_with_its_limit_of_time():
    for limit_s in (10, 600, 1800):
        core = Core()
        core.settings.auto_limit_s = limit_s
        core.safety.auto.configure(core.settings)
        core.arm()
        core.auto()
        core.tick()
        assert core.safety.auto.left_ms == 1000 * limit_s - 1
        core.safety.auto.left_ms = 3
        assert lasts(core) == 2
        assert spent(core, codes.AUTO_LIMIT)
        assert core.safety.auto.left_ms == 1000 * limit_s - 1
    # It runs while the chair stands, too.
    core = going()
    core.i.linear_permille = 0
    core.run(100)
    assert core.safety.auto.left_ms == LIMIT_MS - 101


def test_a_press_never_becomes_auto_nor_stops_being_it():
    core = going()
    core.i.mode = codes.CONTINUOUS
    core.tick()
    core.i.mode = codes.AUTO
    assert spent(core, codes.BAD_COMMAND)
    core = Core()
    core.arm()
    core.i.linear_permille = 500
    core.press(codes.DRIVE)
    core.tick()
    core.watched = True
    core.i.mode = codes.AUTO
    core.tick()
    assert core.safety.override == codes.BAD_COMMAND
    assert not core.moving()


def test_a_press_made_before_it_was_armed_never_counts():
    core = Core()
    core.see()
    core.auto()
    core.run(400)
    core.hold_ms = 0
    core.i.verb = codes.STOP
    core.make_ready()
    core.order(codes.ARM)
    core.until(core.armed, 200)
    core.i.verb = codes.DRIVE
    core.hold_ms = 150
    for _ in range(20):
        core.tick()
        assert not core.moving()
