"""P8, P10 and P11 end to end: joystick, tick, watchdog and emergency, down to the relay."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from e2e import states
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly

RELAY_MS = 20
WIPER_FAULTS = {
    "wiper_nak": "potentiometer answers nothing",
    "wiper_bus_stuck": "potentiometer's bus stuck",
    "wiper_stuck": "potentiometer reads back wrong",
}


def note_relay(chair: Lockstep, promise: str, cause: str, limit_ms: int = RELAY_MS) -> None:
    open_ms = chair.until(lambda: not chair.world.relay.closed, 100)
    measured(END_TO_END, promise, f"{cause}: relay open", open_ms, limit_ms)


def reset_by_caretaker(chair: Lockstep, bit: int) -> None:
    assert chair.host is not None
    caretaker = chair.host.control.connect("caretaker")
    control = chair.host.control
    assert control.receive(caretaker, {"k": "reset", "token": control.token()}) == []
    chair.until(lambda: not chair.fault(bit), 100)
    chair.host.control.disconnect(caretaker)


@pytest.mark.parametrize("fault", WIPER_FAULTS)
@pytest.mark.parametrize("verb", ["forward", "right"])
def test_p8_the_joystick_fails(fault: str, verb: str) -> None:
    chair = states.driving(verb)
    if fault == "wiper_stuck":
        chair.page.release()  # a wrong value shows when another one is written
    chair.world.faults.inject(fault)
    off_ms = chair.until(lambda: chair.fault(codes.WIPER), 10)
    measured(END_TO_END, "P8", f"{WIPER_FAULTS[fault]}: enable off", off_ms, 4)
    note_relay(chair, "P8", WIPER_FAULTS[fault], 4 + RELAY_MS)
    assert not chair.armed()
    chair.comes_to_rest()
    chair.world.faults.clear(fault)
    chair.stays_still(1500)
    assert chair.fault(codes.WIPER)  # latched
    chair.page.release()
    chair.page.arm()
    chair.stays_still(500)
    assert not chair.armed()
    assert chair.page.shown["arm_reason"] == "wiper"
    reset_by_caretaker(chair, codes.WIPER)
    chair.needs_a_new_press(verb)


def test_p8_two_bad_writes_are_retried(driving: Lockstep) -> None:
    pot = driving.bank.slot(0, 0x2C)
    for _ in range(100):
        pot.set_nak_count(2)
        driving.run(4)
        assert driving.armed(), driving.why()
    assert not driving.neutral()


def test_p8_the_potentiometer_alone_loses_its_supply(driving: Lockstep) -> None:
    for verb in ("forward", "left"):
        driving.page.press(verb)
        driving.run(300)
        before = driving.wipers()
        driving.world.pot.power_on()  # both wipers in the middle, which is not neutral
        driving.one_ms()
        assert driving.wipers() == before  # written anew by the next tick
        assert driving.armed()
    driving.page.release()
    driving.run(3)
    driving.world.pot.power_on()
    driving.one_ms()
    assert driving.neutral()
    kept(END_TO_END, "P8", "the potentiometer resets by itself: written anew in the next tick")


def test_p10_board_hangs(driving: Lockstep) -> None:
    driving.board.hung = True
    note_relay(driving, "P10", "board hangs")
    bite_ms = driving.until(lambda: driving.board.watchdog_bites == 1, 600)
    measured(END_TO_END, "P10", "board hangs: watchdog resets, after the relay", bite_ms, 500)
    driving.until(lambda: driving.board.app is not None, 400)
    assert driving.board.app.reset_cause == 3
    assert driving.neutral()
    driving.needs_a_new_press()


@pytest.mark.parametrize("stall_ms", [21, 40, 300])
def test_p10_tick_stalls(driving: Lockstep, stall_ms: int) -> None:
    driving.board.hung = True
    note_relay(driving, "P10", "tick stalls")
    driving.stays_still(stall_ms - RELAY_MS)
    driving.board.hung = False
    driving.one_ms()
    assert driving.neutral()
    assert driving.fault(codes.TICK_STALLED), driving.why()
    assert not driving.armed()
    driving.needs_a_new_press()


def spoilt(*_: Any) -> None:
    raise ValueError("spoilt")


@pytest.mark.parametrize(
    "spoil",
    [
        lambda app: setattr(app.motion, "step", spoilt),
        lambda app: setattr(app.safety, "step", spoilt),
        lambda app: setattr(app.joystick, "write", spoilt),
        lambda app: setattr(app.safety, "wipers_written", spoilt),
    ],
    ids=["motion", "safety", "joystick", "after the write"],
)
def test_p10_an_exception_inside_the_tick(driving: Lockstep, spoil: Callable[[Any], None]) -> None:
    spoil(driving.board.app)
    driving.one_ms()
    assert driving.bank.pin(2).latch == 0
    note_relay(driving, "P10", "exception inside the tick")
    assert driving.fault(codes.TICK_EXCEPTION)
    driving.stays_still(500)
    driving.board.power_off()
    driving.board.power_on()
    driving.until(lambda: driving.board.app is not None, 400)
    driving.needs_a_new_press()


def test_p10_a_passing_exception_inside_the_tick_is_latched(driving: Lockstep) -> None:
    app = driving.board.app
    app.motion.step, step = spoilt, app.motion.step
    driving.one_ms()
    app.motion.step = step
    driving.one_ms()
    assert driving.neutral()  # the very next tick writes it
    driving.stays_still(1000)
    assert driving.fault(codes.TICK_EXCEPTION)
    reset_by_caretaker(driving, codes.TICK_EXCEPTION)
    driving.needs_a_new_press()


def test_p10_an_exception_in_the_service_loop(driving: Lockstep) -> None:
    driving.board.app.link.poll = spoilt
    driving.one_ms()
    assert driving.neutral()
    note_relay(driving, "P10", "exception in the service loop")
    driving.until(lambda: driving.board.watchdog_bites == 1, 600)
    driving.until(lambda: driving.board.app is not None, 400)
    driving.needs_a_new_press()


def test_p10_three_watchdog_resets_in_a_row_leave_it_off(driving: Lockstep) -> None:
    for _ in range(3):
        driving.until(lambda: driving.board.app is not None, 500)
        driving.board.hung = True
        bites = driving.board.watchdog_bites
        driving.until(lambda b=bites: driving.board.watchdog_bites > b, 600)
    driving.run(2000)
    assert driving.board.app is None  # in the REPL
    assert driving.enable_off()
    driving.stays_still(2000)
    assert driving.host is not None
    assert "watchdog_boots" in driving.host.link.last_words
    driving.board.power_off()
    driving.board.power_on()
    driving.until(lambda: driving.board.app is not None, 500)
    driving.needs_a_new_press()
    kept(END_TO_END, "P10", "three watchdog resets in a row: enable off, in the REPL")


def by_input(chair: Lockstep) -> None:
    chair.world.faults.inject("emergency")


def by_page(chair: Lockstep) -> None:
    chair.page.say(k="emergency")


@pytest.mark.parametrize("state", states.STATES[:-1], ids=lambda s: s.__name__)
@pytest.mark.parametrize("press", [by_input, by_page], ids=["input", "page"])
def test_p11_emergency(
    state: Callable[[Lockstep], None], press: Callable[[Lockstep], None]
) -> None:
    chair = states.chair_in(state)
    press(chair)
    name = "emergency input" if press is by_input else "emergency on the page"
    off_ms = chair.until(lambda: chair.fault(codes.EMERGENCY), 10)
    assert chair.neutral()
    measured(END_TO_END, "P11", f"{name}: enable off", off_ms, 2)
    if chair.world.relay.closed:
        note_relay(chair, "P11", name, 2 + RELAY_MS)
    chair.world.faults.clear("emergency")
    chair.stays_still(200)
    chair.board.reset()  # latched across resets
    chair.until(lambda: chair.board.app is not None, 400)
    chair.until(chair.connected, 1500)
    chair.stays_still(1000)
    chair.page.release()
    chair.page.arm()
    chair.page.reset()
    chair.stays_still(500)
    assert chair.fault(codes.EMERGENCY)
    assert not chair.armed()
    assert chair.host is not None
    assert "not_allowed" in chair.host.refusals  # the driver's page can't reset it
    reset_by_caretaker(chair, codes.EMERGENCY)
    chair.needs_a_new_press()


def test_p11_three_seconds_at_the_chairs_button_reset_it(driving: Lockstep) -> None:
    driving.world.faults.inject("emergency")
    driving.until(driving.neutral, 5)
    driving.world.faults.inject("reset_button")
    driving.stays_still(3200)
    assert driving.fault(codes.EMERGENCY)  # the input is still open
    driving.world.faults.clear("reset_button")
    driving.world.faults.clear("emergency")
    driving.run(50)
    driving.world.faults.inject("reset_button")
    driving.stays_still(2900)
    assert driving.fault(codes.EMERGENCY)
    driving.stays_still(200)
    assert not driving.fault(codes.EMERGENCY)
    driving.world.faults.clear("reset_button")
    driving.needs_a_new_press()
    kept(END_TO_END, "P11", "3 s at the chair's button reset it")
