"""Orders that arrive together: every pair and triple, in every sequence, in one service slice.

The oracle is the promises' text and sees outputs only: the state and faults that the board reports,
its wipers, and who can drive it afterwards.
"""

import copy
import itertools
from functools import cache

import pytest

from gazelink import codes, messages
from gazesim.board_rig import Rig
from promises import CORE, kept

DISARM = (codes.DISARM, codes.DRIVER)
ARM = (codes.ARM, codes.DRIVER)
TAKE_OVER = (codes.ARM, codes.CARETAKER)
EMERGENCY = (codes.EMERGENCY_STOP, codes.DRIVER)
RESET = (codes.RESET_FAULTS, codes.CARETAKER)
DRIVERS_RESET = (codes.RESET_FAULTS, codes.DRIVER)
ORDERS = (DISARM, ARM, TAKE_OVER, EMERGENCY, RESET, DRIVERS_RESET)
BEFORE = ("latched", "ready", "arming", "armed", "driving")
SETTLED_MS = 120


@cache
def prepared(before: str) -> Rig:
    """A board in that state; to be copied, not used."""
    rig = Rig()
    if before in ("armed", "driving"):
        rig.arm()
        rig.run(200)
    else:
        rig.run(1300)
    if before == "latched":
        rig.send(messages.ORDER, (codes.EMERGENCY_STOP, 1, codes.DRIVER))
        rig.run(700)
    if before == "arming":
        rig.give(codes.ARM)
        rig.until(lambda: rig.app.safety.state == codes.ARMING, 40)
        rig._order_left = 0
    if before == "driving":
        rig.press(codes.FORWARD)
        rig.run(60)
        assert not rig.neutral()
    rig.run(2)
    rig._order_number = 100
    return rig


def expected(before: str, orders: tuple[tuple[int, int], ...]) -> tuple[int, int, bool, bool]:
    """State, owner, whether the emergency is latched, whether the old press still drives."""
    owners = [owner for action, owner in orders if action == codes.ARM]
    if EMERGENCY in orders:  # P11: whatever else is asked
        return codes.DISARMED, codes.NOBODY, True, False
    latched = before == "latched" and RESET not in orders
    if DISARM in orders:  # never lost, whatever else is asked
        return codes.DISARMED, codes.NOBODY, latched, False
    if before in ("latched", "ready"):
        # Nobody arms before the faults were seen to be gone.
        if not owners or latched or RESET in orders:
            return codes.DISARMED, codes.NOBODY, latched, False
        return codes.ARMED, owners[-1], False, False
    # P13: one owner, the last who asked; who takes over stops the chair first.
    owner = owners[-1] if owners else codes.DRIVER
    others = len(owners) > 1 or owner != codes.DRIVER
    return codes.ARMED, owner, False, before == "driving" and not others


def drives(rig: Rig, owner: int) -> bool:
    """A new press of that owner moves the chair."""
    trial = copy.deepcopy(rig)
    edge = trial.command[2] % 255 + 1
    trial.command = (codes.FORWARD, codes.CONTINUOUS, edge, owner, 0, 0)
    trial.hold = True
    trial.run(60)
    return not trial.neutral()


@pytest.mark.parametrize("together", [2, pytest.param(3, marks=pytest.mark.recorded)])
@pytest.mark.parametrize("before", BEFORE)
def test_orders_in_one_slice_do_as_each_alone_promises(before: str, together: int) -> None:
    for orders in itertools.product(ORDERS, repeat=together):
        rig = copy.deepcopy(prepared(before))
        for number, (action, owner) in enumerate(orders):
            rig.send(messages.ORDER, (action, 101 + number, owner))
        rig.one_ms()  # the slice
        state, owner, latched, moving = expected(before, orders)
        for _ in range(2):  # P11, P13: within 2 ms of the decoded frame
            rig.one_ms()
        story = f"{before}: {orders}: {rig.why()}"
        if state == codes.DISARMED:
            assert rig.neutral(), story
            assert rig.app.safety.state == codes.DISARMED, story
        assert moving or rig.neutral(), story
        rig.run(SETTLED_MS)
        found = rig.state["status"] & 15
        story = f"{before}: {orders}: {rig.why()}"
        assert found == state, story
        assert bool(rig.state["faults"] >> codes.EMERGENCY & 1) == latched, story
        assert rig.neutral() != moving, story
        if state == codes.ARMED:
            assert [drives(rig, who) for who in (codes.DRIVER, codes.CARETAKER)] == [
                owner == codes.DRIVER,
                owner == codes.CARETAKER,
            ], story
    kept(CORE, "P13", f"orders that arrive together ({before})")
