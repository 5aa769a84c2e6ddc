# The safety core, to the tick: whose press moves the chair; stops by others, arming, sessions.

from gazeboard.core import limits
from gazelink import codes
from gazesim.core_rig import CLOSES_MS, Core, refused


def test_p13_a_command_of_somebody_else_never_lets_an_old_press_go_on():
    for other in range(1, 256):
        core = Core()
        core.i.edge = 99
        core.drive()
        old = core.i.edge
        core.stop()
        core.tick()
        core.i.owner = codes.CARETAKER
        core.i.edge = other
        core.tick()
        core.i.owner = codes.DRIVER
        core.i.edge = old
        core.tick()
        assert not core.moving(), other
        if other != 99:
            core.i.edge = 99
            core.tick()
            assert not core.moving(), other


def test_p13_a_stop_spends_the_press_that_came_in_with_it():
    core = Core()
    core.drive()
    core.press(codes.BACKWARD)
    core.stop()  # after that press, in the same slice
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core.press(codes.FORWARD)
    core.stop()
    core.i.edge += 1  # pressed after the stop, in the same slice
    core.tick()
    assert core.moving()
    core.i.verb = codes.STOP
    core.tick()
    core.i.edge += 1
    core.stop()
    core.tick()
    core.i.verb = codes.FORWARD  # came late, but was pressed before the stop
    assert refused(core, codes.NEEDS_NEW_COMMAND)


def test_p13_anyones_stop_ends_the_press_with_a_reason_for_who_still_holds_it():
    for mode in (codes.STEP, codes.CONTINUOUS):
        core = Core()
        core.drive(codes.FORWARD, mode)
        core.stop()
        assert refused(core, codes.NEEDS_NEW_COMMAND)
        core.press(codes.FORWARD)
        core.tick()
        assert core.moving()
        core.tick()
        assert core.moving()  # the stop is not remembered


def test_p13_only_the_owner_moves():
    for owner in (0, 2, 3):
        core = Core()
        core.drive()
        core.i.owner = owner
        assert refused(core, codes.NOT_OWNER)
        core.i.owner = codes.DRIVER
        assert refused(core, codes.NOT_OWNER)


def test_a_press_held_while_arming_needs_to_be_made_anew():
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.tick()
    core.press(codes.FORWARD)
    core.tick()
    assert core.safety.override == codes.NOT_ARMED
    core.until(core.armed, 200)
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 1)
    core.press(codes.FORWARD)  # in the very tick in which it becomes armed
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    assert core.armed()


def test_p14_after_a_new_session_no_press_of_the_old_life_goes_on():
    core = Core()
    core.drive(codes.FORWARD, codes.STEP)
    old = core.i.edge
    core.new_session()
    core.i.edge = old  # the new host repeats the old press in the same millisecond
    core.i.verb = codes.FORWARD
    core.hold_ms = 0
    core.command(0)
    core.tick()
    assert core.safety.state == codes.DISARMED
    assert core.safety.edge == 0
    assert refused(core, codes.NOT_ARMED)
    core.make_ready()
    core.order(codes.ARM)
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 1)
    core.i.edge = old + 1
    core.tick()
    assert core.armed()
    core.i.edge = old  # no time to live, no step under way: nothing may move
    core.tick()
    assert not core.moving(), core.why()


def test_not_armed_is_the_reason_before_all_others():
    core = Core()
    core.i.clearance_blocked = 15
    core.make_ready()
    core.press(codes.FORWARD)
    assert refused(core, codes.NOT_ARMED)


def test_orders_to_arm_are_counted_across_their_wrap():
    core = Core()
    core.drive()
    core.i.arm_count = 65535
    core.tick()
    core.run(5)
    core.press(codes.FORWARD)
    core.tick()
    assert core.moving()
    core.i.arm_count = 1  # two more: to somebody and back
    core.tick()
    assert not core.moving()
