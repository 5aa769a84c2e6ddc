# A backlog of old frames does not keep a dead host alive (P2, P12).

from gazeboard.core import limits
from gazelink import codes, messages
from gazesim.board_rig import Rig
from gazesim.small_host import clearance


def test_frames_with_an_old_stamp_do_not_count_as_a_living_host():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.host_alive = False
    for ms in range(2 * limits.HOST_SILENT_MS):
        if ms % 20 == 0:
            rig.stamp = (rig.app.outbox.ticks - limits.FRAME_STALE_MS - 20) & 0xFFFF
            rig.send(messages.CLEARANCE, clearance(0, codes.REAL, 5))
        rig.one_ms()
        if ms >= limits.HOST_SILENT_MS:
            assert rig.neutral(), rig.why()
    assert rig.app.safety.faults & (1 << codes.HOST_SILENT)
