# Arming, clocks and refusals on the whole firmware in lockstep virtual time.

from boardtest import raises
from gazeboard.core import ages, limits
from gazelink import codes, messages
from gazesim.board_rig import Rig
from gazesim.lockstep import Files
from promiserig import armed, stays_still_until_pressed_anew


def test_arming_says_what_is_missing():
    rig = Rig()
    rig.host_alive = False
    rig.run(600)
    assert rig.app.safety.arm_reason == codes.NOT_CONNECTED
    rig = Rig()
    rig.lidar_alive = False
    rig.run(1200)
    assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    files = Files()
    files.texts["settings.json"] = "spoilt"
    rig = Rig(0, files)
    rig.run(1200)
    assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.CALIBRATION
    assert "damaged" in rig.app.settings.error
    rig = Rig()
    rig.run(400)
    assert rig.app.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    rig = Rig()
    rig.run(1200)
    rig.give(codes.ARM, codes.NOBODY)
    rig.run(200)
    assert not armed(rig)


def test_a_real_board_never_arms_behind_simulated_or_replayed_data():
    for source in (codes.SIMULATED, codes.REPLAYED):
        rig = Rig()
        rig.source = source
        rig.app.safety.ages.words[ages.SIMULATED] = 0
        rig.run(1200)
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.SIMULATED_SOURCE


def test_the_clocks_wrap_changes_nothing():
    rig = Rig((1 << 30) - 2000000)
    rig.app.outbox.ticks = (1 << 30) - 3000
    rig.app.telemetry._due = (1 << 30) - 3000
    rig.drive()
    for _ in range(2500):
        rig.one_ms()
        assert not rig.neutral()
        assert rig.app.safety.faults == 0, rig.why()
    assert rig.clock.ticks_us() < 3000000  # it has wrapped
    assert rig.app.outbox.ticks < 3000
    rig.press(codes.LEFT)
    rig.run(600)
    assert armed(rig), rig.why()
    assert rig.app.safety.faults == 0
    assert rig.app.outbox.ticks < 10000


def test_a_host_that_stops_reading_delays_nothing():
    rig = Rig()
    rig.drive()
    rig.wire.reading = False
    # No fresh stamp reaches the host, so its commands age by our clock: stale after 100 ms, and
    # what was left of their life then ends as if the driver had let go.
    stopped = rig.until(rig.neutral, 400)
    assert limits.FRAME_STALE_MS < stopped <= limits.COMMAND_TTL_MS + 10
    rig.run(500)  # 64 states wait at most
    assert rig.app.telemetry.dropped > 0
    rig.wire.reading = True
    stays_still_until_pressed_anew(rig)


def test_no_command_can_be_sent_before_a_session():
    # A first command before any HELLO is garbage to the board; the host's own encoder refuses it.
    rig = Rig()
    assert "no session" in raises(
        ValueError, rig.send, messages.COMMAND, (1, 1, 1, 1, 300, 0, 0, 1000, 0)
    )
