# The safety core's judgement of a press, what is blocked given to it directly: which direction
# forbids what, and with which reason.

from gazeboard.core.obstacles import ARC_BLOCKED
from gazelink import codes
from gazesim.core_rig import Core

# verb, linear, turn: bits of the directions that it needs, and what an arc is told as
PRESSES = (
    (codes.FORWARD, 0, 0, 1, codes.DIR_FORWARD),
    (codes.BACKWARD, 0, 0, 2, codes.DIR_BACKWARD),
    (codes.LEFT, 0, 0, 4, codes.DIR_LEFT),
    (codes.RIGHT, 0, 0, 8, codes.DIR_RIGHT),
    (codes.DRIVE, 0, 0, 0, None),
    (codes.DRIVE, 1, 0, 1, codes.DIR_FORWARD),
    (codes.DRIVE, -1, 0, 2, codes.DIR_BACKWARD),
    (codes.DRIVE, 0, 1, 4, codes.DIR_LEFT),
    (codes.DRIVE, 0, -1, 8, codes.DIR_RIGHT),
    (codes.DRIVE, 1, 1, 5, codes.DIR_LEFT),
    (codes.DRIVE, 1, -1, 9, codes.DIR_RIGHT),
    (codes.DRIVE, -1, 1, 6, codes.DIR_LEFT),
    (codes.DRIVE, -1, -1, 10, codes.DIR_RIGHT),
)


# One tick of the safety core alone, `blocked` as Obstacles says it.
def judged(core, verb, linear, turn, blocked, new=True):
    i = core.i
    i.linear_permille = linear
    i.turn_permille = turn
    if new:
        core.press(verb)
    for name in ("host_count", "service_count", "clearance_count", "heading_count"):
        setattr(i, name, (getattr(i, name) + 1) & 0xFFFF)
    core.command(300)
    core.safety.step(i, blocked, True, False, False, False)
    return core.safety.override if not core.safety.permitted else codes.NO_REASON


def lowest(bits):
    return next(bit for bit in range(4) if bits >> bit & 1)


def test_what_is_blocked_refuses_what_needs_it_and_nothing_else():
    core = Core()
    core.arm()
    for verb, linear, turn, needs, _ in PRESSES:
        for blocked in range(16):
            against = blocked & needs
            reason = codes.OBSTACLE_FORWARD + lowest(against) if against else codes.NO_REASON
            assert judged(core, verb, linear, turn, blocked) == reason, (verb, linear, turn)


def test_the_reason_names_the_direction_in_which_creep_is_too_fast():
    core = Core()
    core.arm()
    for verb, linear, turn, needs, _ in PRESSES:
        for at in range(4):
            for creeps in range(16):
                if needs != 1 << at:
                    continue
                reason = codes.OBSTACLE_FORWARD + at
                if creeps >> at & 1:
                    reason = codes.ABOVE_CREEP
                assert judged(core, verb, linear, turn, 1 << at | creeps << 4) == reason


def test_the_reason_of_a_blocked_arc_names_the_side_it_leads_to():
    core = Core()
    core.arm()
    for verb, linear, turn, needs, told in PRESSES:
        if told is None:
            continue
        assert judged(core, verb, linear, turn, ARC_BLOCKED) == codes.OBSTACLE_FORWARD + told
        for blocked in range(16):
            # What stands in a single direction is said first.
            said = codes.OBSTACLE_FORWARD + (lowest(blocked & needs) if blocked & needs else told)
            assert judged(core, verb, linear, turn, ARC_BLOCKED | blocked) == said


def test_what_asks_for_nothing_is_refused_by_no_arc_even_while_the_chair_still_rolls_along_it():
    core = Core()
    core.arm()
    for blocked in range(16):
        assert judged(core, codes.DRIVE, 0, 0, ARC_BLOCKED | blocked) == codes.NO_REASON
        held = judged(core, codes.DRIVE, 0, 0, ARC_BLOCKED | blocked, new=False)
        assert held == codes.NO_REASON
    # The first request of either axis is judged again.
    assert judged(core, codes.DRIVE, 1, 0, ARC_BLOCKED, new=False) == codes.OBSTACLE_FORWARD


def test_a_press_kept_active_is_judged_like_a_new_one():
    core = Core()
    core.arm()
    for verb, linear, turn, needs, _ in PRESSES:
        for blocked in range(1, 16):
            assert judged(core, verb, linear, turn, 0) == codes.NO_REASON
            held = judged(core, verb, linear, turn, blocked, new=False)
            assert (held == codes.NO_REASON) is (blocked & needs == 0)
