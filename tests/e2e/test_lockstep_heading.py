"""P7 and P16 end to end, from the sensor's registers: a heading that lies, a chair that tips."""

from __future__ import annotations

import pytest

from e2e import states
from gazeboard.core import limits
from gazelink import codes
from gazesim.lockstep_chair import Lockstep
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly

HEADING_FAULTS = {
    "imu_freeze": "heading frozen",
    "imu_nak": "heading sensor answers nothing",
    "imu_bus_stuck": "heading sensor's bus stuck",
    "imu_self_reset": "heading sensor resets itself",
    "imu_jump": "heading jumps",
    "imu_error": "heading sensor reports an error",
}
LASTING = ("imu_freeze", "imu_nak", "imu_bus_stuck")  # the others end when it is started again


def heading_fault(chair: Lockstep) -> bool:
    return bool(chair.board.app.safety.faults & codes.HEADING_FAULTS)


@pytest.mark.parametrize("fault", HEADING_FAULTS)
@pytest.mark.parametrize(("verb", "mode"), [("left", "continuous"), ("right", "step")])
def test_p7_a_lying_heading_stops_turns_only(fault: str, verb: str, mode: str) -> None:
    for phase_ms in (0, 3, 7):  # of the 10 ms between two samples
        chair = states.driving(verb, mode, 400, more_ms=phase_ms)
        chair.world.faults.inject(fault)
        neutral_ms = chair.until(chair.neutral, 200)
        cause = HEADING_FAULTS[fault]
        measured(END_TO_END, "P7", cause, neutral_ms, limits.HEADING_OLD_MS)
    assert heading_fault(chair), chair.why()
    assert chair.armed()
    chair.comes_to_rest()
    if fault in LASTING:  # turns are refused, forward is possible
        chair.page.press("right")
        chair.stays_still(500)
        assert chair.override().startswith("heading"), chair.why()
        chair.page.press("forward")
        chair.until(lambda: not chair.neutral(), 10)
        chair.run(1000)
        assert not chair.neutral(), chair.why()
        chair.page.press("left")
        chair.until(chair.neutral, 10)
        chair.world.faults.clear(fault)
    chair.until(lambda: not heading_fault(chair), 5000)  # by itself
    chair.needs_a_new_press("right")
    kept(END_TO_END, "P14", "a heading fault")


def test_p7_single_spikes_are_bridged(turning: Lockstep) -> None:
    turning.world.faults.inject("imu_spike", spike_deg=90.0)
    for _ in range(8000):
        turning.one_ms()
        assert not turning.neutral(), turning.why()
    kept(END_TO_END, "P7", "single bad samples are bridged")


def test_p7_a_turn_by_a_spiking_heading_ends_where_it_should(chair: Lockstep) -> None:
    chair.world.faults.inject("imu_spike", spike_deg=90.0)
    chair.arm()
    for k in range(1, 4):
        chair.page.press("left", "step")
        chair.until(lambda: not chair.neutral(), 10)
        chair.until(chair.neutral, 7000)
        chair.comes_to_rest()
        turned_deg = chair.world.chair.heading_deg
        assert abs(turned_deg - 10 * k) < 3.5 * k, chair.why()


def test_p7_forward_goes_on_when_the_sensor_goes(driving: Lockstep) -> None:
    for fault in ("imu_freeze", "imu_nak", "imu_bus_stuck", "imu_jump", "imu_self_reset"):
        driving.world.faults.inject(fault)
        for _ in range(400):
            driving.one_ms()
            assert not driving.neutral(), driving.why()
        assert heading_fault(driving)
        driving.world.faults.clear(fault)
        driving.run(1000)
    kept(END_TO_END, "P7", "forward stays possible")


@pytest.mark.parametrize("tilt", [{"pitch_deg": 20.0}, {"pitch_deg": 0.0, "roll_deg": -20.0}])
@pytest.mark.parametrize("verb", ["forward", "left"])
def test_p16_tilt(tilt: dict[str, float], verb: str) -> None:
    for phase_ms in (0, 3, 7, 10):  # of the 10 ms between two samples
        chair = states.driving(verb, ms=300, more_ms=phase_ms)
        chair.world.faults.inject("tilt", **tilt)
        neutral_ms = chair.until(chair.neutral, 200)
        measured(END_TO_END, "P16", "tilt beyond the limit", neutral_ms, limits.TILT_MS)
        assert chair.override() == "tilt"
    chair.stays_still(500)
    chair.world.faults.clear("tilt")
    chair.needs_a_new_press(verb)
