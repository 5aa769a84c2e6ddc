"""What the tick puts out is what the plain formulas say: clamped outputs, wiper counts, states."""

from __future__ import annotations

import random
import struct
from types import SimpleNamespace

from gazeboard.core import limits
from gazeboard.core.angle import wrapped
from gazeboard.core.motion import Motion
from gazeboard.io import joystick
from gazeboard.io.settings import Settings
from gazeboard.io.telemetry import Telemetry
from gazeboard.turning.pid import PD
from gazeboard.turning.turn import turn_controller
from gazelink import codes
from gazelink.messages import HEADER_SIZE

_TRIES = 20_000


def _within(value: int, limit: int) -> int:
    return max(-limit, min(limit, value))


def test_outputs_stay_within_settings_cap_and_free_directions() -> None:
    """Motion's limits against two clamps, one after the other, on random commands."""
    rng = random.Random(19)
    settings = Settings()
    motion = Motion(settings, SimpleNamespace(follow=None, update=None, hold=None))
    for _ in range(_TRIES):
        for name in ("linear", "turn", "step_turn", "hold"):
            setattr(settings, f"{name}_permille", rng.choice((0, 50, rng.randint(0, 1000))))
        i = SimpleNamespace(
            cap_permille=rng.choice((0, rng.randint(0, 1000), 1000)),
            verb=rng.randint(0, 5),
            mode=rng.randint(0, 2),
        )
        caps = [rng.choice((0, rng.randint(0, 1000), 1000)) for _ in range(4)]
        blocked = rng.choice((0, rng.randint(0, 15)))
        linear, turn = (rng.choice((0, rng.randint(-1000, 1000))) for _ in range(2))
        if i.verb == codes.DRIVE and rng.randint(0, 1):
            linear = 0
        if i.verb in (codes.LEFT, codes.RIGHT):
            linear = 0
        motion.linear_permille = linear
        motion.turn_permille = turn
        i.turn_permille = turn if linear == 0 else 0  # a drive's; else what holds its heading
        motion._limit(i, i.verb, blocked, caps, None)

        stepwise = i.mode != codes.CONTINUOUS and i.verb != codes.DRIVE
        most = settings.step_turn_permille if stepwise else settings.turn_permille
        if i.verb == codes.FORWARD or linear:
            most = settings.hold_permille
        linear = _within(linear, min(i.cap_permille, settings.linear_permille))
        linear = max(-caps[codes.DIR_BACKWARD], min(caps[codes.DIR_FORWARD], linear))
        turn = _within(turn, min(i.cap_permille, most))
        turn = max(-caps[codes.DIR_RIGHT], min(caps[codes.DIR_LEFT], turn))
        side = codes.DIR_LEFT if turn > 0 else codes.DIR_RIGHT
        if turn and blocked & (1 << side):
            turn = 0
        assert (motion.linear_permille, motion.turn_permille) == (linear, turn)


def test_wiper_counts_are_proportional_and_within_the_window() -> None:
    """Every deflection at every neutral that a setting allows, alike both ways."""
    for neutral in range(limits.WIPER_MIN, limits.WIPER_MAX + 1):
        for permille in range(-1000, 1001):
            by = abs(permille) * limits.WIPER_SPAN // 1000
            count = neutral + by if permille >= 0 else neutral - by
            wanted = max(limits.WIPER_MIN, min(limits.WIPER_MAX, count))
            assert joystick.counts(permille, neutral) == wanted


def test_the_reported_deflection_is_the_least_that_gives_the_count() -> None:
    """So it names the count exactly, never more than was asked for, and 0 at neutral only."""
    for neutral in range(150, 191):
        told = {}
        for asked in range(-1000, 1001):
            count = joystick.counts(asked, neutral)
            permille = told.setdefault(count, joystick.permille(count, neutral))
            assert abs(permille) <= abs(asked)
            assert (permille == 0) == (count == neutral)
            assert joystick.counts(permille, neutral) == count
        assert sorted(told.values()) == [told[count] for count in sorted(told)]
        assert len(set(told.values())) == len(told)


class _Bus:
    def __init__(self) -> None:
        self.wipers = {0x00: 0, 0x80: 0}
        self._at = 0

    def writeto(self, _address: int, octets: bytes) -> None:
        self._at, self.wipers[octets[0]] = octets

    def readfrom_into(self, _address: int, back: bytearray) -> None:
        back[0] = self.wipers[self._at]


def test_each_write_puts_out_what_is_asked_for_now() -> None:
    """Also after a new neutral, and when the chip has forgotten what it was told."""
    rng = random.Random(20)
    bus = _Bus()
    stick = joystick.Joystick(bus)
    neutral = (limits.WIPER_NEUTRAL, limits.WIPER_NEUTRAL)
    for _ in range(_TRIES):
        if rng.random() < 0.01:
            neutral = (rng.randint(150, 190), rng.randint(150, 190))
            stick.set_neutral(*neutral)
        if rng.random() < 0.05:
            bus.wipers = {0x00: rng.randrange(256), 0x80: rng.randrange(256)}
        asked = [rng.choice((0, 0, 300, rng.randint(-1000, 1000))) for _ in range(2)]
        assert stick.write(*asked)
        wanted = [joystick.counts(p, n) for p, n in zip(asked, neutral, strict=True)]
        assert [bus.wipers[0x00], bus.wipers[0x80]] == wanted
        assert [stick.linear_wiper, stick.turn_wiper] == wanted
        assert stick.neutral == (asked == [0, 0])


def test_a_captured_state_is_what_the_board_found() -> None:
    """All fields against struct's own packing; due on a grid of its period."""
    rng = random.Random(21)
    safety = SimpleNamespace()
    stick = SimpleNamespace(neutral_linear=170, neutral_turn=151)
    obstacles = SimpleNamespace()
    telemetry = Telemetry(safety, stick, obstacles)
    ticks = due = 0
    body = bytearray(64)
    for _ in range(_TRIES):
        if rng.random() < 0.02:
            telemetry.period_ms = rng.randint(1, 100)
        for name in ("state", "override", "arm_reason", "first_fault"):
            setattr(safety, name, rng.randint(0, 2 if name == "state" else 255))
        safety.faults = rng.randrange(1 << 30)
        safety.edge, safety.spent_edge = rng.choice((0, rng.randint(1, 255))), rng.randint(0, 255)
        stick.linear_wiper, stick.turn_wiper = rng.randint(85, 254), rng.randint(85, 254)
        obstacles.decisions = rng.randrange(255)
        heading_q4, motion = rng.randrange(5760), rng.randrange(5)
        ticks = (ticks + rng.choice((1, 1, 1, 7, 250))) & 0x3FFFFFFF
        telemetry.capture(ticks, motion, heading_q4)
        if (ticks - due) & 0x20000000:
            assert not telemetry.waits()
            continue
        while not (ticks - due) & 0x20000000:
            due += telemetry.period_ms
        assert telemetry.waits()
        assert telemetry.take(body) == ticks & 0xFFFF
        old = safety.faults & (1 << codes.OBSTACLE_DATA_OLD)
        assert body[HEADER_SIZE : HEADER_SIZE + 16] == struct.pack(
            "<BBBBIHhhBB",
            safety.state | motion << 4,
            safety.override,
            safety.arm_reason,
            safety.first_fault,
            safety.faults,
            heading_q4,
            joystick.permille(stick.linear_wiper, stick.neutral_linear),
            joystick.permille(stick.turn_wiper, stick.neutral_turn),
            safety.edge or safety.spent_edge,
            0xFF if old else obstacles.decisions,
        )


def test_a_heading_is_held_once_a_sample_as_if_in_every_tick() -> None:
    """hold() asked again and again, and kept anew, against the formula worked out each time."""
    rng = random.Random(23)
    settings = Settings()
    turn = turn_controller(settings)
    gains = PD(settings.hold_kp_q4, settings.hold_kd_q4)
    kept_q4, holds = 0, False
    heading_q4, rate_q4 = 0, 0
    for _ in range(_TRIES):
        if rng.random() < 0.05:
            kept_q4, holds = rng.choice((heading_q4, rng.randint(0, 5759))), False
            turn.keep(kept_q4)
        if rng.random() < 0.3:
            heading_q4 = (kept_q4 + rng.randint(-40, 40)) % 5760
            rate_q4 = rng.randint(-20, 20)
        out = gains.update(wrapped(kept_q4 - heading_q4), rate_q4, 1)
        holds = abs(out) >= (6 if holds else 16)
        if not holds:
            out = 0
        else:
            deadband = settings.of_profile("deadband_permille")
            out += deadband if out > 0 else -deadband
        assert turn.hold(heading_q4, rate_q4) == out
