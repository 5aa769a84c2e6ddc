# What a way of some length allows: the formulas of the obstacle distances, said anew in floats.

from gazeboard.core import limits
from gazeboard.core.stopping import LEVELS, Stopping, _turns_alike
from gazeboard.io.settings import Settings
from gazelink import codes
from gazelink.messages import CLEAR_FAR
from gazelink.settings_table import PROFILES, TABLE

LINEAR = (codes.DIR_FORWARD, codes.DIR_BACKWARD)
SEEN = (  # per direction, at full deflection in each profile
    (194, 278, 361, 444, 556),
    (250, 278, 389, 472, 389),
    (364, 637, 728, 910, 910),
    (273, 637, 728, 910, 910),
)
ROWS = ("forward_mm_s", "backward_mm_s", "left_q4_dps", "right_q4_dps")


def changed(**values):
    settings = Settings()
    for name, value in values.items():
        assert hasattr(settings, name), name
        setattr(settings, name, value)
    return settings


def row(settings, name):
    return settings.of_profile(name)


def test_there_are_16_levels():
    assert LEVELS == 16


# Which profiles turn so much alike that the turn rate seen cannot tell them apart: 2.1's 637 and
# 3.1's 728 sixteenths of a degree a second, for one.
ALIKE = ((0,), (1, 2), (1, 2, 3, 4), (1, 2, 3, 4), (1, 2, 3, 4))


def test_with_a_trusted_profile_only_those_that_turn_alike_count():
    for profile, alike in enumerate(ALIKE):
        # Worse rows than anything was seen to have: they count, the others' do not.
        for other in range(len(PROFILES)):
            prefix = "p" + PROFILES[other].replace(".", "_") + "_"
            rows = {"dead_time_ms": 300, "lag_ms": 700, "brake_dps2": 90, "brake_mm_s2": 400}
            worse = {prefix + name: value for name, value in rows.items()}
            settings = changed(profile=profile, **worse)
            for direction in range(4):
                stopping = Stopping(settings, direction, True)
                counts = other in alike
                assert stopping.full == max(SEEN[direction][p] for p in alike)
                assert stopping.dead_ms == (300 if counts else 140)
                assert stopping.tail_ms == (875 if counts else 437)
                if direction in LINEAR:
                    assert stopping.brake == (400 if counts else 500)
                else:
                    assert stopping.brake == 16 * (90 if counts else 150)


def test_changed_rows_do_not_hide_profiles_that_turn_alike():
    # As seen, 4.1 and 5.1 turn like 3.1, whatever their rows say; and 2.1 does if its row says so.
    rows = dict.fromkeys(
        [f"p{n}_1_{side}_q4_dps" for n in (4, 5) for side in ("left", "right")], 80
    )
    assert Stopping(changed(**rows), codes.DIR_FORWARD, True).full == 556
    settings = changed(profile=0, p5_1_right_q4_dps=280)
    assert Stopping(settings, codes.DIR_FORWARD, True).full == 556
    # Nor does a row that turns the selected profile into one that none is like.
    for rate in (80, 2400):
        settings = changed(profile=1, p2_1_left_q4_dps=rate, p2_1_right_q4_dps=rate)
        assert Stopping(settings, codes.DIR_FORWARD, True).full >= 278
    # A deadband takes away more of a turn at half deflection than at full: how much that can be is
    # part of being alike.
    for deadband, full in ((0, 556), (56, 361), (300, 361)):
        settings = changed(profile=1, p2_1_deadband_permille=deadband)
        assert Stopping(settings, codes.DIR_FORWARD, True).full == full, deadband


def test_no_row_makes_the_chair_stop_sooner_than_observed():
    lowest = Settings()
    tamest = Settings()
    for name, _default, low, high in TABLE:
        setattr(lowest, name, low)
        setattr(tamest, name, high if "brake" in name else low)
    for settings in (lowest, tamest):
        for direction in range(4):
            stopping = Stopping(settings, direction, False)
            assert stopping.full == max(SEEN[direction])
            assert (stopping.dead_ms, stopping.tail_ms, stopping.time_ms) == (140, 437, 490)
            if settings is tamest:
                assert stopping.brake == (500 if direction in LINEAR else 16 * 150)
        for profile in range(len(PROFILES)):
            settings.profile = profile
            assert Stopping(settings, codes.DIR_FORWARD, True).full >= SEEN[0][profile]


def test_without_trust_the_fastest_of_all_counts_with_the_weakest_brake():
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
    for reaction_ms, lag_ms, time_ms in ((350, 100, 500), (350, 450, 600), (1000, 800, 1000)):
        settings = changed(reaction_ms=reaction_ms, p3_1_lag_ms=lag_ms, p3_1_dead_time_ms=150)
        assert Stopping(settings, codes.DIR_FORWARD, True).time_ms == time_ms


def test_the_stopping_distance_is_that_of_the_formula():
    for direction, margin in ((codes.DIR_FORWARD, 100), (codes.DIR_LEFT, 48)):
        s = Stopping(changed(profile=3), direction, True)
        for speed in range(0, 901, 20):
            exact = speed * s.time_ms // 1000 + speed * speed // (2 * s.brake) + margin
            assert s.stop(speed) == exact
        assert s.stop(0) == margin
    assert Stopping(changed(stop_margin_mm=300), codes.DIR_BACKWARD, True).stop(0) == 300
    assert Stopping(changed(stop_margin_q4_deg=99), codes.DIR_RIGHT, True).stop(0) == 99


def test_slowing_begins_a_second_of_travel_before_the_stopping_distance():
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


def test_more_distance_never_allows_less_and_far_allows_all_for_any_settings():
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
                assert sorted(s.begin) == list(s.begin)
                assert sorted(s.permille) == s.permille
                assert s.begin[LEVELS] + s.band < CLEAR_FAR
                assert s.begin[0] >= s.margin
                assert 0 <= s.permille[0] <= 1000
                assert 0 < s.permille[1]
                assert s.stop(s.full) < 1 << 30
                if settings is highest:
                    assert s.begin[LEVELS] == s.stop(s.full) + s.full  # a second of it


def test_creep():
    # 120 mm/s of the fastest profile's 556, of 1.2's 194, and of 361, which turns like 2.1; a
    # turn's outermost point, 750 mm off, too.
    settings = changed(profile=0, linear_permille=1000)
    assert Stopping(settings, codes.DIR_FORWARD, True).permille[0] == 120 * 1000 // 194
    assert Stopping(changed(profile=1), codes.DIR_FORWARD, True).permille[0] == 332
    settings = Settings()
    assert Stopping(settings, codes.DIR_FORWARD, False).permille[0] == 215
    assert Stopping(settings, codes.DIR_BACKWARD, False).permille[0] == 254
    # What breaks a turn of the selected profile loose, 155/16 degrees/s and a quarter, is more.
    for trusted in (False, True):
        for direction in (codes.DIR_LEFT, codes.DIR_RIGHT):
            creep = Stopping(settings, direction, trusted).permille[0]
            assert creep == 56 + (1000 - 56) * 155 * 5 // (4 * 728) == 307
    settings = changed(p3_1_breakaway_q4_dps=0)
    assert Stopping(settings, codes.DIR_RIGHT, False).permille[0] == 146 * 1000 // 910
    settings = changed(profile=1, p2_1_breakaway_q4_dps=0)
    assert Stopping(settings, codes.DIR_LEFT, True).permille[0] == 146 * 1000 // 728
    assert Stopping(settings, codes.DIR_FORWARD, True).creep == 120
    # Of a turn's outermost point: 917 sixteenths of a degree in a radian, 750 mm off.
    for mm_s in range(90, 201):
        settings = changed(creep_mm_s=mm_s, p3_1_breakaway_q4_dps=0)
        s = Stopping(settings, codes.DIR_RIGHT, False)
        assert s.permille[0] == max(86, mm_s * 917 // 750 * 1000 // 910), mm_s
    s = Stopping(changed(profile=1), codes.DIR_FORWARD, True)
    assert (s.speed(240), s.speed(241), s.speed(1000)) == (87, 88, 361)  # 86.64, 87.001: up
    # Never below what moves the chair, never above what the settings let out.
    settings = changed(p3_1_deadband_permille=300, p3_1_breakaway_q4_dps=0)
    assert Stopping(settings, codes.DIR_LEFT, True).permille[0] == 330
    assert Stopping(settings, codes.DIR_LEFT, False).permille[0] == 330
    settings = changed(linear_permille=100)
    assert Stopping(settings, codes.DIR_FORWARD, True).permille == [100] * LEVELS + [1000]
    settings = changed(profile=0, creep_mm_s=200)
    assert Stopping(settings, codes.DIR_FORWARD, True).permille[0] == 600


def test_what_needs_more_than_creep_to_start_does_not_creep():
    # In 1.2 it takes 558 permille to break a turn to the left loose: 166 mm/s, but 400 of the
    # fastest profile's chair, which it may be until it was seen to turn.
    settings = changed(profile=0)
    trusted = Stopping(settings, codes.DIR_LEFT, True)
    assert trusted.permille[0] == 56 + 944 * 155 * 5 // (4 * 364) == 558
    doubted = Stopping(settings, codes.DIR_LEFT, False)
    # Tried with as much as may be, 260 mm/s of the outermost point.
    most = limits.CREEP_MOST_MM_S * 917 // limits.OUTERMOST_MM * 1000 // 910
    assert doubted.permille[:2] == [most, most + (1000 - most) // LEVELS]
    # Trusted, no more is to be had; straight on neither.
    for deadband, creep in ((most - 30, most), (most - 29, 0)):
        settings = changed(p3_1_breakaway_q4_dps=0)
        settings.p3_1_deadband_permille = deadband  # more than may be set
        s = Stopping(settings, codes.DIR_RIGHT, True)
        assert s.permille[0] == creep
    assert s.creep == 0
    assert s.permille[1] > 0
    assert s.begin[0] == s.stop(0) == s.margin
    for mm_s, creep in ((782, 332), (783, 332), (788, 0)):
        settings = changed(p3_1_forward_mm_s=mm_s, p3_1_deadband_permille=300)
        for trusted in (False, True):
            s = Stopping(settings, codes.DIR_FORWARD, trusted)
            assert (s.permille[0] > 0) == (creep > 0), mm_s
    # Too little to tell a quick chair from a slow one is not tried.
    for rate, creep in ((1056, 300), (1062, 0)):
        settings = changed(profile=0, p5_1_left_q4_dps=rate)
        assert (Stopping(settings, codes.DIR_LEFT, False).permille[0] > 0) == (creep > 0)


def test_no_settings_make_creep_faster_than_it_may_be():
    dice = 12345
    for _ in range(40):
        settings = Settings()
        for name, _default, low, high in TABLE:
            dice = (dice * 75 + 74) % 65537
            setattr(settings, name, (low, high, low + dice % (high - low + 1))[dice % 3])
        for fitted in (0, 1):
            settings.relay_fitted = fitted
            for direction in range(4):
                for trusted in (False, True):
                    s = Stopping(settings, direction, trusted)
                    fastest = s.creep if fitted else s.speed(s.permille[LEVELS])
                    if direction not in LINEAR:
                        fastest = fastest * limits.OUTERMOST_MM / 917
                    assert fastest <= limits.CREEP_MOST_MM_S + 2


def test_turning_counts_the_higher_of_its_two_outputs():
    for turn, step in ((400, 700), (700, 400)):
        s = Stopping(changed(turn_permille=turn, step_turn_permille=step), codes.DIR_LEFT, True)
        assert s.begin[LEVELS] == s.stop(s.speed(700)) + s.speed(700)


def test_without_a_relay_every_direction_is_slow():
    sticky = Stopping(changed(relay_fitted=0), codes.DIR_LEFT, False)
    assert sticky.permille == [307] * (LEVELS + 1)  # what moves it at all
    tried = Stopping(changed(relay_fitted=0, profile=0), codes.DIR_LEFT, False)
    assert tried.permille == [348] * (LEVELS + 1)
    fast = changed(relay_fitted=0, p3_1_forward_mm_s=800, p3_1_deadband_permille=300)
    assert Stopping(fast, codes.DIR_FORWARD, False).permille == [0] * (LEVELS + 1)  # too much
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
    slow = changed(relay_fitted=0, profile=0)
    assert Stopping(slow, codes.DIR_FORWARD, True).permille[LEVELS] == 1000  # 194 mm/s


def test_bands():
    assert Stopping(Settings(), codes.DIR_BACKWARD, True).band == limits.BAND_MM
    assert Stopping(Settings(), codes.DIR_RIGHT, True).band == limits.BAND_Q4_DEG


# As a rate at 450 permille says: a deadband of 120 permille leaves 375 permille of it, and the
# selected profile believes in what its own deadband leaves.
def alike(rate, deadband, others):
    faster = rate * ((450 - deadband) * 1000 // (1000 - deadband)) // 375
    most = max(rate, faster) * 5 // 4
    return min(others) <= most and max(others) >= rate * 5 // 8


def test_auto_turns_are_fast_enough_to_confirm_each_profile():
    for profile in range(5):
        for direction in (codes.DIR_LEFT, codes.DIR_RIGHT):
            stopping = Stopping(changed(profile=profile), direction, False)
            assert stopping.auto >= limits.TELLING_PERMILLE, (profile, direction)


def test_profiles_turn_alike_to_a_sixteenth_of_a_degree():
    # Only the rates at which it changes.
    seen = (SEEN[2][4], SEEN[3][4])

    def expected(rate, deadband):
        return any(alike(rate, deadband, (2400, was)) for was in seen)

    settings = changed(profile=1, p5_1_left_q4_dps=2400, p5_1_right_q4_dps=2400)
    for deadband in range(0, 300, 3):
        settings.p2_1_deadband_permille = deadband
        rates = [
            r for r in range(400, 900) if expected(r, deadband) and not expected(r - 1, deadband)
        ]
        assert rates
        for rate in rates:
            for tried in (rate - 1, rate):
                settings.p2_1_left_q4_dps = settings.p2_1_right_q4_dps = tried
                assert _turns_alike(settings, 4) is (tried == rate), (deadband, tried)
    for rate in (1600, 1601, 1604):
        for other in (rate * 5 // 8 - 1, rate * 5 // 8):
            settings = changed(profile=1)
            settings.p2_1_left_q4_dps = settings.p2_1_right_q4_dps = rate
            settings.p5_1_left_q4_dps = settings.p5_1_right_q4_dps = other
            assert _turns_alike(settings, 4) is (other == rate * 5 // 8)


def test_a_turn_is_tried_with_300_permille_or_not_at_all():
    for rate, creep in ((1056, 300), (1060, 0)):
        settings = changed(p3_1_deadband_permille=300, p3_1_left_q4_dps=rate)
        assert Stopping(settings, codes.DIR_LEFT, False).permille[0] == creep
