# How the chair stops, as the host is told: the board's own formulas at six speeds.

import struct

from gazeboard.core import limits
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.stopping import Stopping
from gazeboard.io.settings import Settings
from gazelink import codes, zone
from gazelink.settings_table import TABLE


def points_of(data):
    step = zone.POINT_SIZE
    return [struct.unpack_from(zone.POINT, data, at) for at in range(0, zone.SIZE, step)]


# One profile rolls on for longer and brakes less: it counts where it may be the selected one.
FAST = {"p3_1_left_q4_dps": 2400, "p3_1_right_q4_dps": 2400}
MIXED = {"p1_2_lag_ms": 800, "p1_2_brake_mm_s2": 300, "p1_2_brake_dps2": 60, "profile": 4}


def changed(values):
    settings = Settings()
    for name in values:
        assert hasattr(settings, name), name
        setattr(settings, name, values[name])
    return settings


def test_the_points_are_standing_and_evenly_from_creep_to_full():
    for values in ({}, MIXED, {"creep_mm_s": 200}):
        settings = changed(values)
        for direction in range(4):
            slow = Stopping(settings, direction, False)
            points = points_of(Obstacles(settings).zone[direction])
            assert points[zone.STANDING] == (0, slow.margin, slow.time_ms, slow.margin)
            assert points[zone.CREEP][0] == slow.creep
            assert points[zone.FULL][0] == slow.full
            for k, point in enumerate(points[1:]):
                assert point[0] == slow.creep + (slow.full - slow.creep) * k // 4


def test_stopping_is_that_of_a_chair_that_may_be_in_any_profile():
    for values in ({}, MIXED, {"reaction_ms": 1000, "p5_1_brake_mm_s2": 200}):
        settings = changed(values)
        for direction in range(4):
            slow = Stopping(settings, direction, False)
            for speed, stop, stop_ms, _way in points_of(Obstacles(settings).zone[direction]):
                assert stop == slow.stop(speed)
                assert stop_ms == slow.stop_ms(speed)
                assert stop_ms == slow.time_ms + speed * 1000 // slow.brake


def test_the_reported_distance_permits_the_speed_where_the_profile_is_trusted_too():
    for values in ({}, MIXED, FAST):
        settings = changed(values)
        for direction in range(4):
            slow = Stopping(settings, direction, False)
            quick = Stopping(settings, direction, True)
            if values is MIXED:
                assert quick.stop(slow.full) < slow.stop(slow.full)
            points = points_of(Obstacles(settings).zone[direction])
            creeps = slow.stop(slow.creep)
            for speed, _stop, _ms, way in points[zone.CREEP :]:
                ahead = (speed - slow.creep) * limits.SLOW_AHEAD_MS // 1000
                assert way == max(creeps, quick.stop(speed) + ahead)


def test_at_the_reported_distance_the_board_permits_that_speed_and_no_more():
    # Whatever the settings: the outputs that the told way permits are no faster.
    for changes in ({}, {"p5_1_brake_mm_s2": 200}, {"reaction_ms": 1000, "p1_2_lag_ms": 800}):
        settings = Settings()
        for name, value in changes.items():
            setattr(settings, name, value)
        made = Obstacles(settings).zone[codes.DIR_FORWARD]
        for trusted in (False, True):
            stopping = Stopping(settings, codes.DIR_FORWARD, trusted)
            for speed, _stop, _ms, way in points_of(made)[zone.CREEP + 1 :]:
                for level, begin in enumerate(stopping.begin):
                    permille = min(stopping.permille[level], settings.linear_permille)
                    if begin <= way:
                        assert stopping.speed(permille) <= speed


def test_every_point_fits_its_field_at_the_worst_settings():
    settings = Settings()
    for name, _default, low, high in TABLE:
        setattr(settings, name, low if "brake" in name else high)
    settings.profile = 4
    for points in Obstacles(settings).zone:
        found = points_of(points)
        for now, then in zip(found[1:], found):
            assert now[0] >= then[0] and now[1] >= then[1] and now[2] >= then[2]
        assert found[zone.FULL][1] < 65535 and found[zone.FULL][2] < 65535
