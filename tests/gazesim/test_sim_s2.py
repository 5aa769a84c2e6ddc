"""The RPLIDAR S2, byte for byte: replies, nodes, capsules, motor, faults; no pty and no clock."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazesim.s2 import CHAIR_ARCS, S2

STOP, SCAN, INFO, HEALTH, RATE = b"\xa5\x25", b"\xa5\x20", b"\xa5\x50", b"\xa5\x52", b"\xa5\x59"
DENSE = bytes.fromhex("a58205010000000023")
MOTOR_ON, MOTOR_OFF = bytes.fromhex("a5a802580255"), bytes.fromhex("a5a80200000f")


def three_metres(angles):
    return np.full(len(angles), 3.0)


def device(ranger=three_metres):
    return S2(ranger, seed=1)


def run(lidar, seconds):
    return b"".join(lidar.step(0.001) for _ in range(round(seconds * 1000)))


def ask(lidar, request):
    lidar.receive(request)
    return lidar.step(0.001)


def nodes(data):
    raw = np.frombuffer(data[: len(data) // 5 * 5], dtype=np.uint8).reshape(-1, 5).astype(int)
    first, check = raw[:, 0] & 1, raw[:, 1] & 1
    assert ((raw[:, 0] >> 1 & 1) == 1 - first).all()
    assert check.all()
    angle_deg = ((raw[:, 1] | raw[:, 2] << 8) >> 1) / 64
    return first, angle_deg, (raw[:, 3] | raw[:, 4] << 8) / 4


def test_info_health_and_sample_rate():
    lidar = device()
    info = ask(lidar, INFO)
    assert info[:7] == bytes.fromhex("a55a1400000004")
    assert info[7:11] == bytes((0x71, 2, 1, 18))
    assert info[11:14] == b"SIM"
    assert len(info) == 27
    assert ask(lidar, HEALTH) == bytes.fromhex("a55a0300000006000000")
    rate = ask(lidar, RATE)
    assert rate[:7] == bytes.fromhex("a55a0400000015")
    assert struct.unpack("<HH", rate[7:]) == (62, 31)


def test_a_standard_scan_is_16_kHz_at_10_turns_a_second():
    lidar = device()
    assert ask(lidar, SCAN)[:7] == bytes.fromhex("a55a0500004081")
    first, angle_deg, distance_mm = nodes(run(lidar, 1.0))
    assert len(first) == pytest.approx(16000, abs=100)
    assert first.sum() == 10
    turn = np.flatnonzero(first)
    assert np.diff(turn) == pytest.approx(1600)
    assert (angle_deg[turn] < 1.0).all()
    rising = np.diff(angle_deg[turn[0] : turn[1]])
    assert (rising > 0).all()
    seen = distance_mm[distance_mm > 0]
    assert len(seen) > 0.98 * len(distance_mm)
    ahead = (angle_deg < 100) | (angle_deg > 260)
    assert np.median(distance_mm[ahead]) == pytest.approx(3000, abs=3)
    assert distance_mm[ahead & (distance_mm > 0)].std() < 15


def test_raw_angles_are_clockwise():
    def wall_on_the_left(angles):
        left = np.sin(angles) > 0.5
        return np.where(left, 1.0, 4.0)

    lidar = device(wall_on_the_left)
    lidar.receive(SCAN)
    lidar.step(0.001)
    _, angle_deg, distance_mm = nodes(run(lidar, 0.2))
    near = (distance_mm > 500) & (distance_mm < 2000)
    assert near.any()
    assert ((angle_deg[near] > 205) & (angle_deg[near] < 335)).all()


def test_the_chair_blocks_its_arcs():
    lidar = device()
    ask(lidar, SCAN)
    _, angle_deg, distance_mm = nodes(run(lidar, 0.2))
    start, stop, distance = CHAIR_ARCS[0]
    behind = (angle_deg > start + 1) & (angle_deg < stop - 1) & (distance_mm > 0)
    assert np.median(distance_mm[behind]) == pytest.approx(distance * 1000, abs=5)


def test_what_is_too_far_for_a_node_is_no_measurement():
    lidar = device(lambda angles: np.full(len(angles), 20.0))
    ask(lidar, SCAN)
    _, angle_deg, distance_mm = nodes(run(lidar, 0.1))
    assert (distance_mm[angle_deg < 100] == 0).all()


def test_dense_capsules_are_32_kHz_with_good_checksums():
    lidar = device()
    data = ask(lidar, DENSE) + run(lidar, 1.0)
    assert data[:7] == bytes.fromhex("a55a5400004085")
    data = data[7:]
    assert len(data) % 84 == 0
    capsules = np.frombuffer(data, dtype=np.uint8).reshape(-1, 84)
    assert len(capsules) == pytest.approx(800, abs=5)
    assert (capsules[:, 0] >> 4 == 0xA).all()
    assert (capsules[:, 1] >> 4 == 0x5).all()
    checksum = np.bitwise_xor.reduce(capsules[:, 2:], axis=1)
    assert ((capsules[:, 0] & 15) | (capsules[:, 1] & 15) << 4 == checksum).all()
    start = capsules[:, 2].astype(int) | capsules[:, 3].astype(int) << 8
    assert start[0] & 0x8000  # the encoder's reset
    assert not (start[1:] & 0x8000).any()
    step_deg = np.diff((start & 0x7FFF) / 64) % 360
    assert step_deg == pytest.approx(4.5, abs=0.05)  # 40 of 3200 points a turn
    points = capsules[0, 4:].copy().view("<u2")
    assert np.median(points) == pytest.approx(3000, abs=20)


def test_stop_ends_the_scan_and_the_motor_runs_on():
    lidar = device()
    ask(lidar, SCAN)
    ask(lidar, STOP)
    assert run(lidar, 0.2) == b""
    ask(lidar, SCAN)
    assert run(lidar, 0.02)  # at once: it never stopped turning


def test_no_motor_no_points_and_it_takes_time_to_spin_up():
    lidar = device()
    ask(lidar, MOTOR_OFF)
    ask(lidar, SCAN)
    assert run(lidar, 1.0) == b""
    lidar.receive(MOTOR_ON)
    assert run(lidar, 0.4) == b""
    assert run(lidar, 0.2)


def test_queries_during_a_scan_are_not_answered():
    lidar = device()
    ask(lidar, SCAN)
    lidar.receive(INFO)
    nodes(run(lidar, 0.1))  # nothing but nodes


def test_a_request_with_a_wrong_checksum_is_ignored():
    lidar = device()
    assert ask(lidar, DENSE[:-1] + b"\x00") == b""
    assert ask(lidar, INFO)


def test_the_a2_motor_command_of_the_library_does_nothing():
    lidar = device()
    assert ask(lidar, bytes.fromhex("a5f002000057")) == b""
    ask(lidar, SCAN)
    assert run(lidar, 0.1)


def test_requests_may_come_byte_by_byte_after_garbage():
    lidar = device()
    for byte in b"\x00\xff\x13" + INFO:
        lidar.receive(bytes((byte,)))
    assert len(lidar.step(0.001)) == 27


@given(st.binary(max_size=200))
def test_no_garbage_upsets_it(garbage):
    lidar = device()
    lidar.receive(garbage)
    lidar.receive(bytes(300) + b"\xa5\x40")  # ends any command that it waited for; then reset
    run(lidar, 0.6)
    assert ask(lidar, INFO)[:2] == b"\xa5\x5a"


def test_protection_stop_ends_the_scan_and_shows_in_health():
    lidar = device()
    ask(lidar, SCAN)
    lidar.protection_stop = True
    assert run(lidar, 0.2) == b""
    assert ask(lidar, SCAN) == b""
    assert ask(lidar, HEALTH)[7] == 2
    lidar.protection_stop = False
    assert ask(lidar, HEALTH)[7] == 0


def test_a_stalled_lidar_and_a_blocked_mirror_send_nothing():
    for name in ("stalled", "mirror_blocked"):
        lidar = device()
        ask(lidar, SCAN)
        setattr(lidar, name, True)
        assert run(lidar, 0.2) == b""
        setattr(lidar, name, False)
        assert run(lidar, 0.2)


def test_damaged_bytes_are_damaged_in_the_share_asked_for():
    lidar = device()
    ask(lidar, SCAN)
    clean = len(run(lidar, 1.0))
    lidar.drop = 0.1
    assert len(run(lidar, 1.0)) == pytest.approx(0.9 * clean, rel=0.05)
    lidar.drop, lidar.corrupt = 0.0, 0.01
    data = run(lidar, 1.0)
    raw = np.frombuffer(data, dtype=np.uint8).reshape(-1, 5)
    bad = (raw[:, 1] & 1 == 0).mean()  # the check bit, hit in about half of 1 %
    assert 0.002 < bad < 0.012


def test_equal_seeds_give_equal_bytes():
    streams = []
    for _ in range(2):
        lidar = device()
        lidar.receive(SCAN)
        streams.append(run(lidar, 0.3))
    assert streams[0] == streams[1]


def test_a_frozen_lidar_repeats_its_last_turn():
    lidar = device()
    ask(lidar, SCAN)
    _, _, before_mm = nodes(run(lidar, 0.1))
    lidar.beams.frozen = True
    _, _, first_mm = nodes(run(lidar, 0.1))
    _, _, second_mm = nodes(run(lidar, 0.1))
    assert first_mm.tolist() == second_mm.tolist()
    assert np.isin(first_mm, before_mm).mean() > 0.9
    lidar.beams.frozen = False
    _, _, third_mm = nodes(run(lidar, 0.1))
    assert (third_mm == second_mm).mean() < 0.5


def test_a_covered_arc_returns_nothing():
    lidar = device()
    ask(lidar, SCAN)
    lidar.beams.covered_deg = (-60.0, 30.0)
    _, angle_deg, distance_mm = nodes(run(lidar, 0.2))
    ours_deg = (180.0 - angle_deg) % 360.0 - 180.0
    covered = (ours_deg > -60.0) & (ours_deg < 30.0)
    assert (distance_mm[covered] == 0).all()
    assert (distance_mm[~covered] > 0).mean() > 0.98


def test_noise_and_speckle():
    lidar = device()
    ask(lidar, DENSE)
    lidar.beams.noise_m, lidar.beams.speckle = 0.03, 0.02
    capsules = np.frombuffer(run(lidar, 1.0), dtype=np.uint8).reshape(-1, 84)
    distance_mm = np.ascontiguousarray(capsules[:, 4:]).view("<u2").reshape(-1, 3200)[:, :1000]
    stray = (distance_mm > 0) & (np.abs(distance_mm.astype(int) - 3000) > 200)
    assert stray.mean() == pytest.approx(0.02, abs=0.005)
    assert distance_mm[(distance_mm > 0) & ~stray].std() == pytest.approx(30, abs=5)


def test_a_power_dip_leaves_it_idle_with_its_motor_off():
    lidar = device()
    ask(lidar, DENSE)
    lidar.power_dip()
    assert run(lidar, 0.3) == b""
    ask(lidar, DENSE)
    assert run(lidar, 1.0) == b""
    lidar.receive(MOTOR_ON)
    run(lidar, 0.6)
    assert run(lidar, 0.1)
