# What a way of some length allows: the formulas of the obstacle distances, said anew in floats.

from gazeboard import limits
from gazeboard.settings import Settings
from gazeboard.stopping import LEVELS, Stopping
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from gazelink.settings_table import PROFILES, TABLE

LINEAR = (codes.DIR_FORWARD, codes.DIR_BACKWARD)
ROWS = ("forward_mm_s", "backward_mm_s", "left_q4_dps", "right_q4_dps")


def changed(**values):
    settings = Settings()
    for name, value in values.items():
        assert hasattr(settings, name), name
        setattr(settings, name, value)
    return settings


def row(settings, name):
    return settings.of_profile(name)


def test_levels():
    assert LEVELS == 16


def test_a_trusted_profile_counts_alone():
    for profile in range(len(PROFILES)):
        settings = changed(
            profile=profile, p3_1_dead_time_ms=77, p3_1_lag_ms=60, p3_1_brake_dps2=90
        )
        for direction in range(4):
            stopping = Stopping(settings, direction, True)
            assert stopping.full == row(settings, ROWS[direction])
            assert stopping.dead_ms == row(settings, "dead_time_ms")
            lag_ms = row(settings, "lag_ms")
            assert stopping.tail_ms == lag_ms + lag_ms // 4
            if direction in LINEAR:
                assert stopping.brake == row(settings, "brake_mm_s2")
            else:
                assert stopping.brake == 16 * row(settings, "brake_dps2")


def test_else_the_fastest_of_all_with_the_weakest_brake():
    settings = changed(
        p1_2_dead_time_ms=300,
        p2_1_lag_ms=700,
        p4_1_brake_mm_s2=400,
        p5_1_brake_dps2=70,
        p3_1_right_q4_dps=1500,
    )
    stoppings = [Stopping(settings, direction, False) for direction in range(4)]
    assert [s.full for s in stoppings] == [556, 472, 910, 1500]
    assert [s.brake for s in stoppings] == [400, 400, 70 * 16, 70 * 16]
    for s in stoppings:
        assert (s.dead_ms, s.tail_ms, s.time_ms) == (300, 875, 1000)


def test_the_reaction_time_is_at_least_what_the_chair_takes():
    for reaction_ms, lag_ms, time_ms in ((350, 100, 350), (350, 250, 400), (1000, 800, 1000)):
        settings = changed(reaction_ms=reaction_ms, p3_1_lag_ms=lag_ms, p3_1_dead_time_ms=150)
        assert Stopping(settings, codes.DIR_FORWARD, True).time_ms == time_ms


def test_the_way_to_stop():
    for direction, margin in ((codes.DIR_FORWARD, 100), (codes.DIR_LEFT, 48)):
        s = Stopping(changed(profile=3), direction, True)
        for speed in range(0, 901, 20):
            exact = speed * s.time_ms // 1000 + speed * speed // (2 * s.brake) + margin
            assert s.stop(speed) == exact
        assert s.stop(0) == margin
    assert Stopping(changed(stop_margin_mm=300), codes.DIR_BACKWARD, True).stop(0) == 300
    assert Stopping(changed(stop_margin_q4_deg=99), codes.DIR_RIGHT, True).stop(0) == 99


def test_slowing_begins_a_second_of_the_speed_before_the_way_to_stop():
    for direction in range(4):
        for trusted in (False, True):
            s = Stopping(Settings(), direction, trusted)
            assert len(s.begin) == len(s.permille) == LEVELS + 1
            assert s.begin[0] == s.stop(s.creep) == s.stop(s.speed(s.permille[0]))
            for k in range(1, LEVELS):
                v = s.speed(s.permille[k])
                assert s.begin[k] == s.stop(v) + v * limits.SLOW_AHEAD_MS // 1000
            most = 600 if direction in LINEAR else 1000
            v = s.speed(most)
            assert s.begin[LEVELS] == s.stop(v) + v
            assert s.permille[LEVELS] == 1000
            steps = [s.permille[k + 1] - s.permille[k] for k in range(LEVELS - 1)]
            assert max(steps) - min(steps) <= 1  # evenly, from creep to the most there is
            assert abs(most - s.permille[LEVELS - 1] - steps[0]) <= 1


def test_more_way_never_allows_less_and_far_allows_all_for_any_settings():
    lowest = Settings()
    highest = Settings()
    for name, _default, low, high in TABLE:
        setattr(lowest, name, low)
        setattr(highest, name, high)
    for settings in (
        Settings(),
        lowest,
        highest,
        changed(creep_mm_s=200, linear_permille=50, turn_permille=50, step_turn_permille=50),
    ):
        for direction in range(4):
            for trusted in (False, True):
                s = Stopping(settings, direction, trusted)
                assert sorted(s.begin) == s.begin
                assert sorted(s.permille) == s.permille
                assert s.begin[LEVELS] + s.band < CLEAR_FAR
                assert s.begin[0] >= s.margin
                assert 0 < s.permille[0] <= 1000
                assert s.stop(s.full) < 1 << 30
                if settings is highest:
                    assert s.begin[LEVELS] == s.stop(s.full) + s.full  # a second of it


def test_creep():
    # 120 mm/s of 361 and of the fastest profile's 556; a turn's outermost point, 750 mm off, too.
    settings = Settings()
    assert Stopping(settings, codes.DIR_FORWARD, True).permille[0] == 332
    assert Stopping(settings, codes.DIR_FORWARD, False).permille[0] == 215
    assert Stopping(settings, codes.DIR_BACKWARD, False).permille[0] == 254
    # What breaks a turn of the selected profile loose, 155/16 degrees/s and a quarter, is more.
    for trusted in (False, True):
        for direction in (codes.DIR_LEFT, codes.DIR_RIGHT):
            creep = Stopping(settings, direction, trusted).permille[0]
            assert creep == 56 + (1000 - 56) * 155 * 5 // (4 * 728) == 307
    settings = changed(p3_1_breakaway_q4_dps=0)
    assert Stopping(settings, codes.DIR_LEFT, True).permille[0] == 146 * 1000 // 728
    assert Stopping(settings, codes.DIR_RIGHT, False).permille[0] == 160
    assert Stopping(settings, codes.DIR_FORWARD, True).creep == 120
    # Of a turn's outermost point: 917 sixteenths of a degree in a radian, 750 mm off.
    for mm_s in range(90, 201):
        settings = changed(creep_mm_s=mm_s, p3_1_breakaway_q4_dps=0)
        s = Stopping(settings, codes.DIR_RIGHT, False)
        assert s.permille[0] == max(86, mm_s * 917 // 750 * 1000 // 910), mm_s
    s = Stopping(Settings(), codes.DIR_FORWARD, True)
    assert (s.speed(240), s.speed(241), s.speed(1000)) == (87, 88, 361)  # 86.64, 87.001: up
    # Never below what moves the chair, never above what the settings let out.
    settings = changed(p3_1_deadband_permille=300, p3_1_breakaway_q4_dps=0)
    assert Stopping(settings, codes.DIR_LEFT, True).permille[0] == 330
    assert Stopping(settings, codes.DIR_LEFT, False).permille[0] == 330
    settings = changed(linear_permille=100)
    assert Stopping(settings, codes.DIR_FORWARD, True).permille == [100] * LEVELS + [1000]
    settings = changed(p3_1_forward_mm_s=100)
    assert Stopping(settings, codes.DIR_FORWARD, True).permille[0] == 600


def test_turning_counts_the_higher_of_its_two_outputs():
    for turn, step in ((400, 700), (700, 400)):
        s = Stopping(changed(turn_permille=turn, step_turn_permille=step), codes.DIR_LEFT, True)
        assert s.begin[LEVELS] == s.stop(s.speed(700)) + s.speed(700)


def test_without_a_relay_every_way_is_slow():
    sticky = Stopping(changed(relay_fitted=0), codes.DIR_LEFT, False)
    assert sticky.permille == [307] * (LEVELS + 1)  # what moves it at all
    settings = changed(relay_fitted=0, p3_1_breakaway_q4_dps=0)
    for direction in range(4):
        for trusted in (False, True):
            s = Stopping(settings, direction, trusted)
            most_mm_s = s.speed(s.permille[LEVELS])
            if direction not in LINEAR:
                most_mm_s = most_mm_s * limits.OUTERMOST_MM / 917  # of the outermost point
            assert limits.NO_RELAY_MM_S - 3 <= most_mm_s <= limits.NO_RELAY_MM_S + 1
            v = s.speed(s.permille[LEVELS])
            assert s.begin[LEVELS] == s.stop(v) + v
    assert Stopping(settings, codes.DIR_FORWARD, False).permille[LEVELS] == 200 * 1000 // 556
    assert Stopping(settings, codes.DIR_LEFT, False).permille[LEVELS] == 244 * 1000 // 910
    slow = changed(relay_fitted=0, linear_permille=150)
    s = Stopping(slow, codes.DIR_FORWARD, True)
    assert s.begin[LEVELS] == s.stop(s.speed(150)) + s.speed(150)
    fast = changed(relay_fitted=0, p3_1_forward_mm_s=100)
    assert Stopping(fast, codes.DIR_FORWARD, True).permille[LEVELS] == 1000


def test_bands():
    assert Stopping(Settings(), codes.DIR_BACKWARD, True).band == limits.BAND_MM
    assert Stopping(Settings(), codes.DIR_RIGHT, True).band == limits.BAND_Q4_DEG
