"""P14 and P15 end to end: the plug, the power and the host come and go in every state."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from e2e import states
from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly

in_every_state = pytest.mark.parametrize("enter", states.STATES, ids=lambda s: s.__name__)
RELAY_MS = 20


def drives_again(chair: Lockstep) -> None:
    states.clear_latched(chair)
    chair.needs_a_new_press()
    kept(END_TO_END, "P14", "a reconnect in any state")


@in_every_state
@pytest.mark.parametrize("out_ms", [1, 90, 400, 1500])
def test_p14_cable_pulled_and_replugged(enter: Callable[[Lockstep], None], out_ms: int) -> None:
    chair = states.chair_in(enter)
    received_before_ms = chair.unheard_ms
    chair.cable.pull()
    moved_ms = 0
    for ms in range(1, out_ms + 1):
        chair.one_ms()
        if not chair.neutral():
            moved_ms = ms
    if moved_ms:
        measured(
            END_TO_END, "P2", "cable pulled", received_before_ms + moved_ms, limits.HOST_SILENT_MS
        )
    chair.cable.plug()
    for _ in range(400):
        chair.one_ms()
        assert chair.harmless() or chair.unheard_ms <= limits.HOST_SILENT_MS, chair.why()
    drives_again(chair)
    assert chair.host is not None
    assert chair.host.link.sessions == 2


@in_every_state
def test_p15_board_loses_its_power(enter: Callable[[Lockstep], None]) -> None:
    chair = states.chair_in(enter)
    was_closed = chair.world.relay.closed
    chair.cable.pull()
    chair.board.power_off()
    open_ms = chair.until(lambda: not chair.world.relay.closed, 50)
    if was_closed:
        measured(END_TO_END, "P15", "power of the board pulled: relay open", open_ms, RELAY_MS)
    chair.comes_to_rest()
    chair.run(500)
    chair.board.power_on()  # the wipers come back in the middle, which is not neutral
    chair.cable.plug()
    chair.until(lambda: chair.board.app is not None, 500)
    assert chair.neutral()  # P1, before the first tick
    assert chair.enable_off()
    drives_again(chair)


@in_every_state
@pytest.mark.parametrize("dip_ms", [1, 30])
def test_p15_brown_out(enter: Callable[[Lockstep], None], dip_ms: int) -> None:
    chair = states.chair_in(enter)
    was_closed = chair.world.relay.closed
    stood = chair.stands()
    chair.board.power_off()
    chair.world.pot.power_on()  # half backward and half right, until the relay has opened
    open_ms = chair.until(lambda: not chair.world.relay.closed, 50)
    if was_closed:
        measured(
            END_TO_END, "P15", "brown-out of board and joystick: relay open", open_ms, RELAY_MS
        )
    chair.run(dip_ms)
    chair.board.power_on()
    while chair.board.app is None:
        chair.one_ms()
        speed_m_s = chair.world.chair.speed_m_s
        assert speed_m_s > -0.001, chair.why()  # too short a push to be felt
        assert abs(speed_m_s) < 0.001 or not stood, chair.why()
    assert chair.neutral()
    drives_again(chair)


@in_every_state
def test_p14_board_resets(enter: Callable[[Lockstep], None]) -> None:
    chair = states.chair_in(enter)
    was_closed = chair.world.relay.closed
    chair.board.reset()
    open_ms = chair.until(lambda: not chair.world.relay.closed, 50)
    if was_closed:
        measured(END_TO_END, "P15", "the board resets: relay open", open_ms, RELAY_MS)
    chair.until(lambda: chair.board.app is not None, 500)
    assert chair.neutral()
    drives_again(chair)


@in_every_state
def test_p14_host_killed_and_started_again(enter: Callable[[Lockstep], None]) -> None:
    chair = states.chair_in(enter)
    chair.kill_host()
    chair.run(700)
    chair.start_host()
    drives_again(chair)


@pytest.mark.parametrize("order", ["board first", "host first", "cable last", "page last"])
def test_p14_any_order_of_power_up(order: str) -> None:
    chair = Lockstep()
    if order == "board first":
        chair.kill_host()
        chair.run(3000)
        chair.start_host()
    elif order == "host first":
        chair.board.power_off()
        chair.run(3000)
        chair.board.power_on()
    elif order == "cable last":
        chair.cable.pull()
        chair.run(3000)
        chair.cable.plug()
    else:
        chair.page.close()
        chair.run(3000)
        assert chair.host is not None
        chair.page.open(chair.host)
    chair.stays_still(500)
    drives_again(chair)


def test_p14_forty_replugs_in_a_row(chair: Lockstep) -> None:
    chair.arm()
    for k in range(40):
        chair.cable.pull()
        chair.stays_still(1 + 37 * k % 160)
        chair.cable.plug()
        chair.stays_still(1 + 53 * k % 190)
    drives_again(chair)


def test_p1_early_commands_never_move_and_do_not_count_later(chair: Lockstep) -> None:
    chair.page.press("forward")  # the board has just been switched on
    chair.stays_still(3000)
    assert chair.host is not None
    assert set(chair.host.refusals) <= {"not_armed", "not_connected"}
    chair.page.arm()
    chair.run(400)
    chair.stays_still(1000)
    chair.page.release()
    if not chair.armed():
        chair.arm()
    chair.page.press("forward")
    chair.until(lambda: not chair.neutral(), 10)
    kept(END_TO_END, "P1", "commands before the link is up")


def test_p1_neutral_and_enable_off_before_the_first_tick(chair: Lockstep) -> None:
    fresh = Lockstep()
    assert fresh.neutral()
    assert fresh.ticks() == 0
    measured(END_TO_END, "P1", "power-on: neutral, in ticks", fresh.ticks(), 0)
    for _ in range(1500):
        fresh.one_ms()
        assert fresh.enable_off()
        assert fresh.neutral()
    assert fresh.board.app.safety.state == codes.DISARMED
