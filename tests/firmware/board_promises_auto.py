# Promises P17 to P20 on the whole firmware: a motion that nobody holds.

from gazeboard.core import limits
from gazelink import arcs, codes, messages
from gazelink.settings_table import index_of
from gazesim.board_rig import Rig
from promiserig import armed, ask
from promises import CORE, kept, measured

SUPERVISION_MS = 3000
TICK_MS = 1


def going(linear=500, turn=0, **settings):
    rig = Rig()
    rig.run(1200)
    for name, value in settings.items():
        assert ask(rig, codes.SETTING_SET, index_of(name), value) == (value, codes.NO_REASON)
    rig.arm()
    rig.auto(linear, turn)
    rig.run(60)
    assert not rig.neutral(), rig.why()
    return rig


# Neutral, and the press never moves it again; a new one does ("Verder").
def needs_a_new_press(rig, reason=None):
    if reason is not None:
        assert rig.app.safety.override == reason, rig.why()
    rig.host_alive = rig.hold = rig.watched = True
    rig.blocked = rig.unseen = rig.views = rig.bypass = 0
    for _ in range(400):
        rig.one_ms()
        assert rig.neutral(), rig.why()
    if not armed(rig):
        rig.release()
        rig.arm()
    rig.auto()
    rig.until(lambda: not rig.neutral(), 60)


def said(rig, message, *values):
    rig.send(message, values)
    return rig.until(rig.neutral, 20)


def test_p17_a_planner_that_falls_silent():
    for ttl_ms in (150, 300, 65535, 50):
        rig = going()
        rig.host_alive = False
        verb, mode, edge, owner, linear, turn = rig.command
        rig.send(messages.SUPERVISION, (edge, owner, 0))
        rig.send(messages.COMMAND, (verb, mode, edge, owner, ttl_ms, linear, turn, 1000, 0))
        ms = 0
        while not rig.neutral():
            if ms % 20 == 19:
                rig.see()  # the host lives, and all else
            rig.one_ms()
            ms += 1
        assert rig.app.safety.override == codes.COMMAND_EXPIRED
        assert ms <= ttl_ms
        measured(CORE, "P17", "no newer value of the planner", ms, limits.AUTO_TTL_MS)
        needs_a_new_press(rig)


def test_p18_nobody_watches_any_more():
    for setting_ms, age_ms in ((500, 0), (500, 300), (SUPERVISION_MS, 0), (10000, 300)):
        rig = going(supervision_ms=setting_ms)
        rig.watched = False
        rig.send(messages.SUPERVISION, (rig.command[2], codes.CARETAKER, age_ms))
        ms = rig.until(rig.neutral, setting_ms + 100) + age_ms
        cause = f"supervision not renewed, {setting_ms} ms set"
        measured(CORE, "P18", cause, ms, setting_ms + TICK_MS)
        assert ms > setting_ms - 30
        needs_a_new_press(rig, codes.SUPERVISION_LOST)


def test_p18_supervision_that_ends_ends_the_motion_at_once():
    rig = going()
    rig.watched = False
    ms = said(rig, messages.SUPERVISION, rig.command[2], codes.DRIVER, 60000)
    measured(CORE, "P18", "who watched lets go", ms, 2)
    needs_a_new_press(rig, codes.SUPERVISION_LOST)


def test_p18_only_people_watch_and_only_this_press():
    rig = going()
    rig.watched = False
    edge = rig.command[2]
    bad = rig.app.link.incoming.bad
    for owner in (codes.NOBODY, 3, 255):
        rig.send(messages.SUPERVISION, (edge, owner, 0))
    rig.run(3)
    assert rig.app.link.incoming.bad == bad + 3
    assert not rig.neutral()
    said(rig, messages.SUPERVISION, edge + 1, codes.DRIVER, 0)
    needs_a_new_press(rig, codes.SUPERVISION_LOST)


def test_p18_a_late_or_replayed_supervision_is_none():
    rig = going()
    rig.watched = False
    rig.send(messages.SUPERVISION, (rig.command[2], codes.DRIVER, 0))
    recorded = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
    rig.run(1000)
    stale = rig.app.link.incoming.stale
    rig.wire.push(recorded, len(recorded))
    rig.run(20)
    assert rig.app.link.incoming.stale > stale or rig.app.link._decoder.corrupt
    rig.until(rig.neutral, SUPERVISION_MS - 1000)
    for _ in range(20):
        rig.wire.push(recorded, len(recorded))
        rig.run(50)
        assert rig.neutral()
    needs_a_new_press(rig)
    # Late by its own stamp: refused.
    rig = going()
    rig.watched = False
    stamp = rig.stamp
    rig.run(300)
    rig.stamp = (stamp - 20) & 0xFFFF
    stale = rig.app.link.incoming.stale
    rig.send(messages.SUPERVISION, (rig.command[2], codes.DRIVER, 0))
    rig.run(5)
    assert rig.app.link.incoming.stale == stale + 1
    kept(CORE, "P18", "a supervision replayed or late")


def test_p19_never_where_no_lidar_sees():
    for linear, turn, direction in ((500, 0, 0), (-500, 0, 1), (0, 500, 2), (0, -500, 3)):
        rig = going(linear, turn)
        rig.host_alive = False
        rig.unseen = 1 << direction
        rig.see()
        ms = rig.until(rig.neutral, 20)
        measured(CORE, "P19", "its direction is not seen any more", ms, 2)
        assert rig.app.safety.override == codes.OBSTACLE_FORWARD + direction
        rig = Rig()
        rig.unseen = 1 << direction
        rig.arm()
        rig.auto(linear, turn)
        for _ in range(500):
            rig.one_ms()
            assert rig.neutral()
    for linear, turn, quadrant in ((500, 400, 0), (-500, 400, 1), (500, -400, 2), (-500, -400, 3)):
        rig = going(linear, turn)
        rig.host_alive = False
        rig.views = 16 << quadrant
        rig.see()
        ms = rig.until(rig.neutral, 20)
        measured(CORE, "P19", "an arc of both its axes is not seen any more", ms, 2)


def test_p19_never_by_a_bypass():
    rig = Rig()
    rig.arm()
    rig.blocked = 15
    rig.ways = bytearray(arcs.SIZE)
    rig.bypass = 1
    rig.run(300)
    for linear, turn in ((500, 0), (0, 500), (500, 500)):
        rig.auto(linear, turn)
        for _ in range(200):
            rig.one_ms()
            assert rig.neutral(), rig.why()
    rig.watched = False
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)  # a person may
    kept(CORE, "P19", "a bypass while it is blocked")


def test_p19_never_above_its_own_speed():
    for mm_s in (250, 350):
        for linear, turn in ((1000, 0), (-1000, 0), (0, 1000), (0, -1000), (1000, 1000)):
            rig = going(linear, turn, auto_mm_s=mm_s, linear_permille=1000, turn_permille=1000)
            for _ in range(500):
                rig.one_ms()
                motion = rig.app.motion
                # The fastest profile's forward, backward and turn, the last at 0.75 m.
                fastest = 556 if motion.linear_permille > 0 else 472
                assert abs(motion.linear_permille) * fastest // 1000 <= mm_s
                assert abs(motion.turn_permille) * 910 // 1000 * 750 // 917 <= mm_s
                assert not rig.neutral()
    kept(CORE, "P19", "more is asked for than its speed")


def test_p20_any_press_ends_it():
    # The press and the auto motion's next command are read in the same slice.
    for owner, turn in ((codes.DRIVER, 500), (codes.CARETAKER, 0)):
        rig = going()
        edge = rig.command[2]
        other = (codes.FORWARD, codes.CONTINUOUS, edge + 1, owner, 300, 0, 0, 1000, 0)
        rig.send(messages.COMMAND, other)
        auto = (codes.DRIVE, codes.AUTO, edge, codes.DRIVER, 150, 500, turn, 1000, 0)
        rig.send(messages.COMMAND, auto)
        ms = rig.until(rig.neutral, 20)
        measured(CORE, "P20", "a press by anyone", ms, 2 * TICK_MS)
        needs_a_new_press(rig)


def test_p20_a_bypass_press_ends_it():
    rig = going()
    ms = said(rig, messages.BYPASS, 7, 300)
    measured(CORE, "P20", "a bypass press", ms, 2 * TICK_MS)
    needs_a_new_press(rig, codes.ANOTHER_PRESS)
    # One that is held since before begins nothing new, and helps nothing.
    rig.bypass = 8
    rig.run(100)
    rig.auto()
    rig.until(lambda: not rig.neutral(), 60)


def test_p20_stop_disarm_emergency_and_a_take_over_end_it():
    rig = going()
    ms = said(rig, messages.COMMAND, codes.STOP, 0, 0, codes.CARETAKER, 0, 0, 0, 1000, 0)
    measured(CORE, "P20", "Stop by anyone", ms, 2 * TICK_MS)
    needs_a_new_press(rig)
    for action in (codes.DISARM, codes.EMERGENCY_STOP):
        rig = going()
        ms = said(rig, messages.ORDER, action, 9, codes.CARETAKER)
        measured(CORE, "P20", codes.ORDERS[action], ms, 2 * TICK_MS)
        assert not armed(rig)
    rig = going()
    ms = said(rig, messages.ORDER, codes.ARM, 9, codes.CARETAKER)
    measured(CORE, "P20", "a take-over", ms, 2 * TICK_MS)
    for _ in range(300):
        rig.one_ms()
        assert rig.neutral()


def test_p20_overruled_for_10_s_it_ends_before_that_it_waits():
    rig = going()
    rig.blocked = 15
    rig.until(rig.neutral, 60)
    rig.run(9000)
    rig.blocked = 0
    rig.until(lambda: not rig.neutral(), 1000)  # the person has passed
    rig.blocked = 15
    rig.until(rig.neutral, 60)
    over = codes.AUTO_OVERRULED
    ms = rig.until(lambda: rig.app.safety.override == over, 11_000)
    measured(CORE, "P20", "an obstacle overrules it for 10 s", ms, limits.AUTO_OVERRULED_MS + 1)
    needs_a_new_press(rig, over)


def test_p20_its_limit_of_time():
    rig = going(auto_limit_s=10)
    ms = rig.until(rig.neutral, 10_100)
    measured(CORE, "P20", "its limit of time", ms, 10_000)
    assert ms > 9_900
    needs_a_new_press(rig, codes.AUTO_LIMIT)


def test_p20_another_session_ends_it():
    rig = going()
    rig.host_alive = False
    rig.say_hello(rig.session + 1)
    rig.until(rig.neutral, 20)
    assert not armed(rig)
