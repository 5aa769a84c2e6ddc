# The safety core: which presses are spent by stops and sessions, and what is taken back to nothing.

from gazeboard.core import ages, limits
from gazelink import codes
from gazesim.core_rig import Core, refused


def pressed(core, edge, verb=codes.FORWARD):
    core.press(verb)
    core.i.edge = edge
    core.tick()
    return core.moving()


def stopped(core, edge):
    core.i.stop_edge = edge
    core.i.stop_count += 1
    core.release()
    core.tick()


def test_a_stop_spends_its_press_once_and_not_for_ever():
    core = Core()
    core.arm()
    assert pressed(core, 10)
    stopped(core, 10)
    for edge in (70, 130, 190, 250, 55, 115):
        assert pressed(core, edge), edge
        core.release()
        core.run(3)


def test_a_stop_without_a_press_or_with_an_older_one_gives_none_back():
    for edge, older in ((200, 0), (20, 10), (200, 190)):
        core = Core()
        core.arm()
        assert pressed(core, edge)
        core.release()
        core.tick()
        stopped(core, older)
        assert not pressed(core, edge)
        assert not pressed(core, (older + edge) // 2 if older else 180)
        assert pressed(core, edge + 1)


def test_a_press_spends_all_before_it():
    core = Core()
    core.arm()
    assert pressed(core, 20)
    assert pressed(core, 40)
    for edge in (20, 30, 39, 19):
        assert not pressed(core, edge), edge
    assert pressed(core, 41)


def test_a_new_sessions_presses_are_numbered_anew_even_in_its_first_tick():
    core = Core()
    core.arm()
    assert pressed(core, 200)
    core.i.session_count += 1
    assert not pressed(core, 100)
    core.release()
    core.arm()
    assert pressed(core, 101)


def test_a_press_ended_by_a_session_reports_it_while_none_is_requested():
    core = Core()
    core.drive()
    core.i.session_count += 1
    core.i.edge = 0
    core.tick()
    assert not core.moving()
    assert core.safety.override == codes.NOT_CONNECTED


def test_a_command_whose_time_has_run_out_stays_so():
    core = Core()
    core.arm()
    core.command(3)
    core.run(10)
    assert core.safety._words[ages.TTL] == 0
    core.i.verb = codes.FORWARD
    core.i.mode = codes.CONTINUOUS
    core.i.edge = 9
    core.i.owner = codes.DRIVER
    assert refused(core, codes.COMMAND_EXPIRED)


def test_a_release_is_neutral_in_its_tick_and_stays_so():
    for mode in (codes.STEP, codes.CONTINUOUS):
        for verb in range(codes.FORWARD, codes.DRIVE + 1):
            core = Core()
            core.i.linear_permille = 300
            core.i.turn_permille = 100
            core.drive(verb, mode)
            core.run(20)
            assert core.moving()
            core.release()
            for _ in range(3):
                core.tick()
                assert not core.moving(), (verb, mode)
                assert not core.safety.permitted
                assert core.safety.override == codes.NO_REASON


def test_a_motion_has_no_reason_and_neither_has_a_stop():
    core = Core()
    core.arm()
    core.i.clearance_blocked = 1
    core.see()
    core.press(codes.FORWARD)
    assert refused(core, codes.OBSTACLE_FORWARD)
    core.press(codes.LEFT)
    core.tick()
    assert core.moving()
    assert core.safety.override == codes.NO_REASON
    core.press(codes.FORWARD)
    assert refused(core, codes.OBSTACLE_FORWARD)
    core.release()
    core.tick()
    assert core.safety.override == codes.NO_REASON


def test_a_neutral_that_moved_is_proven_for_its_whole_time():
    core = Core()
    core.see()
    core.make_ready()
    core.safety.neutral_moved()
    core.tick()
    assert core.safety._words[ages.NEUTRAL] == 1
    core.run(limits.NEUTRAL_PROVEN_MS - 1)
    assert core.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON


def test_neutral_is_proven_for_a_minute_at_most():
    core = Core()
    core.see()
    for ms, after in ((0, 1), (59999, 60000), (60000, 60000), (59998, 59999)):
        core.safety._words[ages.NEUTRAL] = ms
        core.tick()
        assert core.safety._words[ages.NEUTRAL] == after


def test_a_contact_is_judged_anew_when_it_is_set_again_as_not_fitted():
    core = Core(relay_fitted=False)
    core.contact = False
    core.run(limits.RELAY_RELEASE_MS)
    core.safety.set_relay_fitted(False)
    core.contact = True
    core.run(2 * limits.RELAY_RELEASE_MS)
    assert not core.fault(codes.RELAY_UNEXPECTED)
    core.contact = False
    core.run(limits.RELAY_RELEASE_MS)
    assert core.fault(codes.RELAY_UNEXPECTED)


def test_a_contact_is_judged_anew_after_a_reset():
    core = Core(relay_fitted=False)
    for contact in (False, True):
        core.contact = contact
        core.run(limits.RELAY_RELEASE_MS)
    assert core.fault(codes.RELAY_UNEXPECTED)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.run(3)
    assert not core.fault(codes.RELAY_UNEXPECTED)
    core.contact = False
    core.run(limits.RELAY_RELEASE_MS)
    assert core.fault(codes.RELAY_UNEXPECTED)


def test_time_without_ticks_adds_to_a_headings_age():
    core = Core()
    core.see()
    core.imu = False
    core.run(limits.HEADING_OLD_MS // 2)
    core.safety.missed_ms = limits.HEADING_OLD_MS // 2
    core.tick()
    assert core.fault(codes.HEADING_BUS)


def test_each_lost_heading_ends_a_sticks_turns_until_it_is_pressed_anew():
    for fault in range(len(codes.FAULTS)):
        if not codes.HEADING_FAULTS >> fault & 1:
            continue
        core = Core()
        core.arm()
        core.i.linear_permille = 300
        core.i.turn_permille = 0
        core.press(codes.DRIVE)
        core.tick()
        core.i.heading_faults = 1 << fault
        core.run(3)
        assert core.moving()
        core.i.heading_faults = 0
        core.i.turn_permille = 100
        assert refused(core, codes.NEEDS_NEW_COMMAND)


def test_a_heading_that_was_lost_before_the_press_takes_nothing_from_it():
    core = Core()
    core.arm()
    core.i.linear_permille = 300
    core.press(codes.DRIVE)
    core.tick()
    core.i.heading_faults = codes.HEADING_FAULTS
    core.run(3)
    core.i.heading_faults = 0
    core.press(codes.DRIVE)
    core.tick()
    core.i.turn_permille = 100
    core.run(3)
    assert core.motion.turn_permille == 100


def test_the_sensor_sets_no_other_fault_than_a_headings():
    core = Core()
    core.i.heading_faults = -1
    core.run(3)
    assert core.safety.faults & codes.HEADING_FAULTS == codes.HEADING_FAULTS
    for fault in (codes.EMERGENCY, codes.WIPER, codes.HOST_SILENT + 1, codes.RELAY_STUCK):
        assert not core.fault(fault)
    core.i.heading_faults = 0
    core.run(600)
    core.i.heading_faults = 1 << codes.EMERGENCY | 1 << codes.STORAGE | 1
    core.run(3)
    assert core.safety.faults == 0
