# How the chair stops, as the board tells it to the host: over the wire, at the board's own numbers.

import struct

from gazelink import codes, zone
from gazelink.settings_table import TABLE, index_of
from gazesim.board_rig import Rig
from promiserig import ask

SLUGGISH = (("p5_1_brake_mm_s2", 200), ("reaction_ms", 1000))


def points_of(data):
    step = zone.POINT_SIZE
    return [struct.unpack_from(zone.POINT, data, at) for at in range(0, zone.SIZE, step)]


def told(rig, direction=codes.DIR_FORWARD):
    return points_of(rig.zones[direction])


def connected(rig):
    return rig.until(lambda: len(rig.zones) == 4, 1000)


def put(rig, name, value):
    assert ask(rig, codes.SETTING_SET, index_of(name), value)[1] == codes.NO_REASON


# By the promise's words, in floats: d = v t + v^2 / 2a + margin, of the worst profile.
def far_mm(speed, reaction_s, brake, margin):
    return speed * reaction_s + speed * speed / (2.0 * brake) + margin


def test_each_session_receives_all_directions_at_once():
    rig = Rig()
    connected(rig)
    begun = rig.app.outbox.ticks
    rig.zones.clear()
    rig.keys.end()
    rig.until(lambda: not rig.keys.live, 1)
    rig.say_hello(4242)
    waited = rig.until(lambda: len(rig.zones) == 4, 60)
    assert waited <= 60 and rig.app.outbox.ticks > begun


def test_the_last_point_is_full_speed_of_the_fastest_profile_and_what_stopping_takes_there():
    rig = Rig()
    connected(rig)
    speed, stop, stop_ms, _way = told(rig)[zone.FULL]
    assert speed == 556
    # Dead time and lag, 140 + 350 ms, are more than the reaction's 350.
    assert abs(stop - far_mm(556, 0.490, 500, 100)) <= 2
    assert abs(stop_ms - (490 + 556 * 1000 / 500)) <= 2
    speed, stop, stop_ms, _way = told(rig, codes.DIR_LEFT)[zone.FULL]
    assert speed == 910
    assert abs(stop - far_mm(910, 0.490, 16 * 150, 48)) <= 2


def test_the_first_points_are_standing_and_creep():
    rig = Rig()
    connected(rig)
    points = told(rig)
    assert points[zone.STANDING][:3] == (0, 100, 490)
    speed, stop, _ms, way = points[zone.CREEP]
    assert 120 <= speed <= 121
    assert abs(stop - far_mm(120, 0.490, 500, 100)) <= 3
    assert way == stop


def test_a_change_of_the_settings_is_sent_at_once():
    rig = Rig()
    connected(rig)
    before = [told(rig, direction) for direction in range(4)]
    for name, value in SLUGGISH:
        put(rig, name, value)
    rig.run(30)
    speed, stop, stop_ms, _way = told(rig)[zone.FULL]
    assert speed == 556
    assert abs(stop - far_mm(556, 1.0, 200, 100)) <= 2
    assert abs(stop_ms - (1000 + 556 * 1000 / 200)) <= 2
    for direction in range(4):
        assert told(rig, direction)[zone.FULL][1] > before[direction][zone.FULL][1]


def test_no_setting_makes_it_stop_sooner_than_the_observed_chair():
    rig = Rig()
    connected(rig)
    before = [told(rig, direction) for direction in range(4)]
    for name, _default, low, high in TABLE:
        if name[0] == "p" and name[1].isdigit():
            put(rig, name, high if "brake" in name else low)
    rig.run(30)
    for direction in range(4):
        for at in (zone.STANDING, zone.FULL):
            now, then = told(rig, direction)[at], before[direction][at]
            assert now[0] >= then[0] and now[1] >= then[1] and now[2] >= then[2]


def test_a_lost_frame_is_sent_again_within_a_second():
    rig = Rig()
    connected(rig)
    rig.run(100)
    rig.zones.clear()
    assert rig.until(lambda: len(rig.zones) == 4, 1010) > 500
