"""The host's stop zone is the board's: in each session, after each change, with each board."""

from __future__ import annotations

import pytest

from gazeboard.io.settings import Settings
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazelink import codes
from gazelink.settings_table import index_of
from gazesim.lockstep_chair import Lockstep

WEAK = (("p5_1_brake_mm_s2", 200), ("reaction_ms", 1000))


def of_board(chair: Lockstep) -> list[float]:
    """What the board itself takes to stop from the fastest speed, per direction."""
    stopping = chair.board.app.obstacles._stopping[:4]
    unit = (1000.0, 1000.0, 16.0, 16.0)
    return [one.stop(one.full) / per for one, per in zip(stopping, unit, strict=True)]


def of_host(chair: Lockstep) -> list[float]:
    return [float(one) for one in chair.host.evaluate.zone.far]


def agrees(chair: Lockstep) -> bool:
    return chair.board.app is not None and of_host(chair) == pytest.approx(of_board(chair))


def change(chair: Lockstep, name: str, value: int) -> None:
    chair.host.link.protocol.request_setting(codes.SETTING_SET, index_of(name), value)
    chair.run(40)
    assert getattr(chair.board.app.settings, name) == value


def test_the_first_session_tells_the_zone_before_anything_can_be_armed() -> None:
    chair = Lockstep()
    assert chair.host.evaluate.zone is UNKNOWN
    chair.until(lambda: chair.connected(), 2000)
    chair.until(lambda: agrees(chair), 100)
    assert not chair.armed()


def test_a_change_over_the_wire_counts_with_the_next_view() -> None:
    chair = Lockstep()
    chair.until(lambda: agrees(chair), 2000)
    usual = of_host(chair)
    for name, value in WEAK:
        change(chair, name, value)
    chair.until(lambda: agrees(chair), 100)
    assert of_host(chair)[codes.DIR_FORWARD] > 1.9 * usual[codes.DIR_FORWARD]
    assert chair.host.evaluate.zone.time_s(0.5) == pytest.approx(1.0 + 0.5 / 0.2, abs=0.01)
    # Back to the defaults, all at once.
    chair.host.link.protocol.request_setting(codes.SETTING_DEFAULTS, 0, 0)
    chair.until(lambda: of_host(chair) == usual, 200)


def test_while_the_new_zone_is_under_way_the_host_assumes_the_worst() -> None:
    chair = Lockstep()
    chair.until(lambda: agrees(chair), 2000)
    chair.host.link.protocol.request_setting(codes.SETTING_SET, index_of(WEAK[0][0]), WEAK[0][1])
    seen: list[StopZone] = []
    for _ in range(60):
        chair.one_ms()
        if not seen or seen[-1] is not chair.host.evaluate.zone:
            seen.append(chair.host.evaluate.zone)
    assert len(seen) == 3
    assert seen[1].of(codes.DIR_FORWARD) is None
    assert agrees(chair)


def test_a_new_session_of_another_host_and_of_a_restarted_board_is_told() -> None:
    chair = Lockstep()
    chair.until(lambda: agrees(chair), 2000)
    for name, value in WEAK:
        change(chair, name, value)
    weak = of_board(chair)
    chair.kill_host()
    chair.start_host()
    assert chair.host.evaluate.zone is UNKNOWN
    chair.until(lambda: of_host(chair) == pytest.approx(weak), 4000)
    # The change was not saved: the board that comes back brakes as ever.
    chair.board.reset()
    chair.until(lambda: of_host(chair)[codes.DIR_FORWARD] < 0.8 and agrees(chair), 8000)


def test_a_board_of_other_settings_in_the_place_of_the_last() -> None:
    chair = Lockstep()
    chair.until(lambda: agrees(chair), 2000)
    usual = of_host(chair)
    other = Settings()
    for name, value in WEAK:
        setattr(other, name, value)
    chair.cable.pull()
    chair.until(lambda: chair.host.evaluate.zone.of(codes.DIR_FORWARD) is None, 2000)
    chair.board.power_off()
    chair.board.files.store("settings.json", other.text())
    chair.board.power_on()
    chair.cable.plug()
    chair.until(lambda: agrees(chair), 8000)
    assert of_host(chair)[codes.DIR_FORWARD] > 1.9 * usual[codes.DIR_FORWARD]
