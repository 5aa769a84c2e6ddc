# The safety core in time without ticks, after the neutral was moved, and where creep is more than
# a direction may have.

from gazeboard.core import ages, limits
from gazelink import codes
from gazesim.core_rig import Core

SOURCES = ("host", "service", "lidar")


# A chair that drives, one of its sources just gone silent.
def silent(source):
    core = Core()
    core.drive()
    setattr(core, source, False)
    return core


def stands(core):
    return not core.moving()


def test_p2_ms_without_ticks_are_in_every_age():
    for source in SOURCES:
        core = silent(source)
        all_ms = core.until(lambda core=core: stands(core), 2000)
        for missed in (1, 20, all_ms - 2):
            core = silent(source)
            core.safety.missed_ms = missed
            ms = core.until(lambda core=core: stands(core), 2000)
            assert all_ms - missed - 1 <= ms <= all_ms - missed, (source, missed)
            assert core.safety.missed_ms == 0


def test_p2_ms_without_ticks_are_in_a_commands_time_to_live():
    for missed in (1, 50, 200):
        core = Core()
        core.drive()
        core.hold_ms = 0
        core.command(300)
        core.tick()
        before = core.safety.ages.words[ages.TTL]
        core.safety.missed_ms = missed
        core.tick()
        assert core.safety.ages.words[ages.TTL] == before - 1 - missed
    core.safety.missed_ms = 1000
    core.tick()
    assert core.safety.ages.words[ages.TTL] == 0
    assert not core.moving()


def test_p4_ms_without_ticks_are_in_a_steps_time():
    core = Core()
    core.drive(codes.FORWARD, codes.STEP)
    core.clock.owes = True
    core.clock.step = lambda elapsed_us: 3
    ticks = core.until(lambda: stands(core), 2000)
    assert ticks == core.settings.step_forward_ms // 4


def test_no_age_runs_over():
    core = Core()
    core.drive()
    core.safety.missed_ms = 1 << 20
    core.tick()
    for age_ms in (
        core.safety.ages.words[ages.HOST],
        core.safety.ages.words[ages.SERVICE],
        core.safety.ages.words[ages.CLEARANCE],
        core.safety.ages.words[ages.HEADING],
    ):
        assert age_ms == limits.AGE_MAX_MS
    core.tick()
    assert not core.moving()


def test_a_neutral_that_moved_is_proven_anew():
    core = Core()
    core.make_ready()
    core.safety.neutral_moved()
    core.tick()
    assert core.safety.arm_reason != codes.NO_REASON
    core.order(codes.ARM)
    core.run(300)
    assert not core.armed()
    ms = 300 + core.until(lambda: core.safety.arm_reason == codes.NO_REASON, 1500)
    assert 480 <= ms <= 520
    core.order(codes.ARM)
    core.until(core.armed, 200)


# Every profile needs half of the full output to move at all: more than creep may be.
def test_p5_what_needs_more_than_creep_says_so():
    core = Core()
    for profile in ("p1_2", "p2_1", "p3_1", "p4_1", "p5_1"):
        setattr(core.settings, profile + "_deadband_permille", 500)
    core.obstacles.configure(core.settings)
    core.arm()
    core.i.clearance_unseen = 1 << codes.DIR_FORWARD
    core.run(100)
    core.press(codes.FORWARD)
    core.run(50)
    assert not core.moving()
    assert core.safety.override == codes.ABOVE_CREEP
