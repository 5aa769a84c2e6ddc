"""The dense decoder: every capsule is decoded, damage costs only its own, garbage is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.sensing.lidar.dense import CAPSULE_SIZE, POINTS, CapsuleDecoder
from gazechair.sensing.lidar.nodes import Nodes
from gazesim.s2_frames import capsules, damaged

PER_TURN = 3200
A_TURN = PER_TURN // POINTS


def room_mm(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """(mirror positions, distances) of a room of 6 x 4 m with thin legs and noise."""
    random = np.random.default_rng(seed)
    turns = (np.arange(count * POINTS) % PER_TURN) / PER_TURN
    angles = turns * 2.0 * np.pi
    with np.errstate(divide="ignore"):
        metres = np.minimum(np.abs(3.0 / np.cos(angles)), np.abs(2.0 / np.sin(angles)))
    for leg in range(6):
        metres[np.abs((turns * 360.0 - 60.0 * leg - 10.0 + 180.0) % 360.0 - 180.0) < 0.6] = 1.0
    metres += random.standard_normal(len(turns)) * 0.006
    return turns, np.where(random.random(len(turns)) < 0.003, 0.0, metres * 1000.0)


def stream(count: int = A_TURN, seed: int = 1) -> bytes:
    return capsules(*room_mm(count, seed), after_reset=True).tobytes()


def decode(data: bytes, size: int = 1 << 20) -> tuple[Nodes, CapsuleDecoder]:
    decoder = CapsuleDecoder()
    parts = [decoder.feed(data[at : at + size]) for at in range(0, len(data), size)]
    return Nodes(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("angles_deg", "distances_m", "starts", "backlog")
        )
    ), decoder


def test_a_clean_stream_comes_out_but_for_the_capsule_that_waits_for_the_next() -> None:
    nodes, decoder = decode(stream(2 * A_TURN))
    assert len(nodes) == (2 * A_TURN - 2) * POINTS  # the last one's end was not seen either
    turns, distances_mm = room_mm(2 * A_TURN)
    expected_deg = (180.0 - turns * 360.0) % 360.0 - 180.0
    turned_deg = (nodes.angles_deg - expected_deg[: len(nodes)] + 180.0) % 360.0 - 180.0
    assert np.abs(turned_deg).max() < 0.02  # a 64th of a degree
    assert np.array_equal(
        np.round(nodes.distances_m * 1000), distances_mm.astype(int)[: len(nodes)]
    )
    assert np.flatnonzero(nodes.starts).tolist() == [PER_TURN]
    assert nodes.backlog[-1] == 2 * POINTS
    assert np.all(np.diff(nodes.backlog) == -1)
    assert decoder.rate_hz == pytest.approx(10.0, abs=0.01)
    assert (decoder.resyncs, decoder.dropped, decoder.implausible) == (0, 0, 0)


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 700))
def test_the_size_of_the_pieces_does_not_matter(size: int) -> None:
    data = stream(30)
    nodes, decoder = decode(data, size)
    whole, _ = decode(data)
    assert np.array_equal(nodes.distances_m, whole.distances_m)
    assert np.allclose(nodes.angles_deg, whole.angles_deg, atol=0.05)
    assert decoder.resyncs == 0


@pytest.mark.parametrize("what", ["lost", "flipped"])
def test_every_single_damaged_byte_costs_its_capsule_and_nothing_else(what: str) -> None:
    good = stream(12)
    clean, _ = decode(good)
    for at in range(CAPSULE_SIZE, 3 * CAPSULE_SIZE):
        data = bytearray(good)
        if what == "lost":
            del data[at]
        else:
            data[at] ^= 0x5A
        nodes, decoder = decode(bytes(data))
        assert len(clean) - 2 * POINTS <= len(nodes) < len(clean)
        assert np.all(np.isin(nodes.distances_m, clean.distances_m))
        _angles_fit(nodes, clean)
        assert decoder.resyncs <= 1


def _angles_fit(nodes: Nodes, clean: Nodes) -> None:
    """Each node is where the clean stream has it, those of a capsule before a gap included."""
    known = {float(d): float(a) for a, d in zip(clean.angles_deg, clean.distances_m, strict=True)}
    counts = dict(zip(*np.unique(clean.distances_m, return_counts=True), strict=True))
    for angle, distance in zip(nodes.angles_deg, nodes.distances_m, strict=True):
        if counts[distance] == 1:
            assert abs(angle - known[float(distance)]) < 0.3


def test_the_capsule_before_a_lost_one_keeps_its_angles() -> None:
    good = stream(20)
    nodes, _ = decode(good[: 10 * CAPSULE_SIZE] + good[11 * CAPSULE_SIZE :])
    steps = (np.diff(nodes.angles_deg) + 180.0) % 360.0 - 180.0
    assert np.count_nonzero(steps < -1.0) == 1
    assert steps.min() == pytest.approx(-4.5 - 0.1125, abs=0.1)


def test_what_an_earlier_reader_left_is_skipped() -> None:
    nodes, decoder = decode(stream(20)[50:])
    assert len(nodes) == 17 * POINTS
    assert decoder.dropped == CAPSULE_SIZE - 50


@settings(deadline=None, max_examples=50)
@given(st.binary(max_size=400), st.integers(0, 30 * CAPSULE_SIZE))
def test_garbage_in_the_middle_is_survived(garbage: bytes, cut: int) -> None:
    good = stream(30)
    nodes, _ = decode(good[:cut] + garbage + good[cut:])
    assert len(nodes) >= 26 * POINTS


@settings(deadline=None, max_examples=100)
@given(st.lists(st.binary(max_size=300), max_size=8))
def test_any_bytes_are_taken_without_an_error(pieces: list[bytes]) -> None:
    decoder = CapsuleDecoder()
    for piece in pieces:
        assert not len(decoder.feed(piece))


def test_noise_yields_nothing() -> None:
    random = np.random.default_rng(5)
    nodes, _ = decode(random.integers(0, 256, 500_000).astype(np.uint8).tobytes(), 3000)
    assert not len(nodes)


def rechecked(rows: np.ndarray) -> np.ndarray:
    """With the checksum of what they hold now, as if the damage had slipped through it."""
    checksum = np.bitwise_xor.reduce(rows[:, 2:], axis=1)
    rows[:, 0] = 0xA0 | (checksum & 0x0F)
    rows[:, 1] = 0x50 | (checksum >> 4)
    return rows


def test_a_good_checksum_at_a_wrong_angle_is_not_believed() -> None:
    rows = capsules(*room_mm(40), after_reset=True)
    rows[20, 3] ^= 0x10  # 64 degrees off
    nodes, decoder = decode(rechecked(rows).tobytes())
    assert len(nodes) == 37 * POINTS
    assert decoder.implausible == 1


def test_a_good_checksum_over_torn_distances_is_not_believed() -> None:
    rows = capsules(*room_mm(40), after_reset=True)
    rows[20, [21, 41]] ^= 0x20  # twice 8 m farther
    nodes, decoder = decode(rows.tobytes())
    assert decoder.spiky == 1
    assert nodes.distances_m.max() < 6.0


@pytest.mark.parametrize("per_turn", [PER_TURN, PER_TURN + 13])
def test_a_thin_thing_seen_in_every_turn_is_believed(per_turn: int) -> None:
    """Also when the capsules begin elsewhere in each turn."""
    points = np.arange(20 * A_TURN * POINTS)
    turns = points % per_turn / per_turn
    distances_mm = np.where(points % per_turn == 500, 1500.0, 3000.0 + points % 7)
    nodes, decoder = decode(capsules(turns, distances_mm, after_reset=True).tobytes(), 336)
    assert np.count_nonzero(np.isclose(nodes.distances_m, 1.5)) >= 18
    assert decoder.spiky == 1


def test_where_speckle_is_common_it_costs_few_capsules() -> None:
    turns, distances_mm = room_mm(20 * A_TURN)
    random = np.random.default_rng(3)
    stray = random.random(len(turns)) < 0.02
    distances_mm[stray] = random.uniform(100.0, 4000.0, int(stray.sum()))
    nodes, _ = decode(capsules(turns, distances_mm, after_reset=True).tobytes(), 336)
    assert len(nodes) > 0.97 * len(turns)


def test_capsules_that_stand_still_are_no_measurements() -> None:
    one = stream(1)
    assert not len(decode(one * 400)[0])


def test_a_mirror_that_changes_its_speed_is_followed() -> None:
    steps = np.repeat(np.linspace(4.5, 6.5, 400), 1)
    starts = np.cumsum(steps) % 360.0
    turns = (starts[:, None] / 360.0 + np.zeros(POINTS)).reshape(-1)
    nodes, decoder = decode(capsules(turns, turns * 0 + 3000.0, after_reset=True).tobytes(), 336)
    assert len(nodes) == 398 * POINTS
    assert decoder.rate_hz == pytest.approx(6.4 / 0.45, rel=0.05)


def test_damage_in_one_byte_of_a_thousand_lets_next_to_nothing_wrong_through() -> None:
    """Some 20,000 capsules here; `gazechair measure obstacles` counts many more."""
    turns, distances_mm = room_mm(20_000)
    rows = capsules(turns, distances_mm, after_reset=True)
    random = np.random.default_rng(9)
    true = {row.tobytes() for row in rows[:, 4:]}
    for corrupt, drop in ((0.001, 0.0), (0.0, 0.001)):
        data = damaged(rows.reshape(-1), random, corrupt, drop)
        nodes, decoder = decode(data.tobytes(), 3360)
        seen = np.round(nodes.distances_m * 1000).astype("<u2").reshape(-1, POINTS)
        wrong = sum(row.tobytes() not in true for row in seen)
        assert wrong <= 1
        assert len(seen) > 0.9 * len(rows)
        assert 0.05 < decoder.dropped / decoder.fed < 0.12


def test_capsules_in_order_come_out_as_they_do_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    data = stream(3 * A_TURN, seed=4)
    short, quick = decode(data, 1700)
    monkeypatch.setattr(CapsuleDecoder, "_fits", lambda *_: False)
    checked, slow = decode(data, 1700)
    for name in ("angles_deg", "distances_m", "starts", "backlog"):
        assert getattr(short, name).tobytes() == getattr(checked, name).tobytes()
    assert (quick.step_deg, quick.implausible, quick.spiky) == (slow.step_deg, 0, slow.spiky)
