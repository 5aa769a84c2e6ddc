# Promises P2, P3 and P12 on the whole firmware in lockstep virtual time: host, driver, frames.

from gazeboard.core import ages, limits
from gazelink import codes, frame, messages
from gazesim.board_rig import Rig
from gazesim.small_host import clearance
from promiserig import armed, stays_still_until_pressed_anew
from promises import CORE, kept, measured


def test_p2_host_silent_is_neutral_within_100_ms_and_disarmed_after_500():
    for verb in (codes.FORWARD, codes.LEFT):
        rig = Rig()
        rig.drive(verb)
        rig.until(lambda: rig.now_ms % 20 == 0, 20)  # a frame was decoded in this very ms
        rig.host_alive = False
        ms = rig.until(rig.neutral, 200)
        measured(CORE, "P2", "host silent", ms, limits.HOST_SILENT_MS)
        ms += rig.until(lambda: not armed(rig), limits.HOST_LOST_MS)
        measured(CORE, "P2", "host silent: disarmed", ms, limits.HOST_LOST_MS)
        rig.host_alive = True
        stays_still_until_pressed_anew(rig)


def test_p2_a_short_silence_keeps_it_armed_but_needs_a_new_press():
    rig = Rig()
    rig.drive()
    rig.host_alive = False
    rig.run(200)
    rig.host_alive = True
    stays_still_until_pressed_anew(rig)
    assert armed(rig)


def test_p3_a_command_not_refreshed_ends_within_300_ms():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.hold = False  # the host lives and repeats the command, its time-to-live is spent
    ms = rig.until(rig.neutral, 400)
    measured(CORE, "P3", "hold not refreshed, page and host alive", ms, limits.COMMAND_TTL_MS)
    assert rig.app.safety.override == codes.COMMAND_EXPIRED
    rig.hold = True
    stays_still_until_pressed_anew(rig)


def test_p3_the_board_itself_counts_down():
    rig = Rig()
    rig.drive()
    rig.host_alive = False
    rig.app.safety.ages.words[ages.HOST] = 0
    moved = 0
    for _ in range(400):
        rig.app.safety.ages.words[ages.HOST] = 0  # only P3 is left to stop it
        rig.app.safety.ages.words[ages.CLEARANCE] = 0
        rig.one_ms()
        moved += not rig.neutral()
    measured(CORE, "P3", "the board alone counts down", moved, limits.COMMAND_TTL_MS)
    assert rig.app.safety.override == codes.COMMAND_EXPIRED


def test_p3_time_on_the_way_counts():
    rig = Rig()
    rig.arm()
    rig.host_alive = False
    rig.until(lambda: rig.now_ms % 10 == 1, 20)
    sent_at = rig.now_ms
    rig.send(
        messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, 9, codes.DRIVER, 300, 0, 0, 1000, 0)
    )
    held = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
    rig.wire.clear()
    rig.run(80)  # the frame waits 80 ms somewhere
    rig.wire.push(held, len(held))
    rig.app.safety.ages.words[ages.HOST] = 0
    for _ in range(400):
        rig.app.safety.ages.words[ages.HOST] = 0
        rig.app.safety.ages.words[ages.CLEARANCE] = 0
        rig.one_ms()
        if not rig.neutral():
            last = rig.now_ms
    measured(CORE, "P3", "time on the way counts", last - sent_at, limits.COMMAND_TTL_MS)


def test_p12_every_single_bit_flip_of_a_command_is_ignored():
    rig = Rig()
    rig.arm()
    values = (codes.FORWARD, codes.CONTINUOUS, 77, codes.DRIVER, 300, 0, 0, 1000, 0)
    messages.COMMAND.pack(rig.encoder.body, values)
    n = rig.encoder.finish(messages.COMMAND, rig.stamp)
    frame = bytes(rig.encoder.wire[:n])
    for bit in range(8 * n):
        spoilt = bytearray(frame)
        spoilt[bit >> 3] ^= 1 << (bit & 7)
        rig.wire.push(spoilt + b"\0", n + 1)
        rig.run(2)
        assert rig.neutral(), bit
    assert rig.app.link._decoder.corrupt >= 8 * n
    kept(CORE, "P12", "every single bit flip")


def test_p12_a_replayed_frame_never_moves():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    rig.host_alive = False
    rig.speak()
    recorded = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
    rig.host_alive = True
    rig.until(lambda: not rig.neutral(), 60)
    rig.release()
    rig.run(400)
    for wait in (1, 50, 99, 100, 101, 1000):
        rig.wire.push(recorded, len(recorded))
        for _ in range(wait):
            rig.one_ms()
            assert rig.neutral()
    assert rig.app.link.incoming.stale > 0
    kept(CORE, "P12", "replayed frames")


def test_p12_frames_of_another_session_boot_or_version_are_ignored():
    from gazelink import frame

    for session, boot, other_nonce, epoch in (
        (0x1235, 0x0B07, 0, 0),
        (0x1234, 0x0B08, 0, 0),
        (0x1234, 0x0B07, 1, 0),
        (0x1234, 0x0B07, 0, 1),
    ):
        rig = Rig()
        rig.arm()
        own = rig.encoder.session
        nonce = bytearray(rig.app.link._nonce)
        nonce[3] ^= other_nonce
        rig.encoder.session = frame.Session()
        rig.encoder.session.begin(session, boot, nonce, epoch, rig.stamp)
        values = (codes.FORWARD, codes.CONTINUOUS, 9, codes.DRIVER, 300, 0, 0, 1000, 0)
        rig.send(messages.COMMAND, values)
        rig.encoder.session = own
        corrupt = rig.app.link._decoder.corrupt
        rig.run(100)
        assert rig.neutral()
        assert rig.app.link._decoder.corrupt == corrupt + 1
    kept(CORE, "P12", "frames of a foreign session")


def test_p12_values_out_of_range_are_ignored_and_counted():
    rig = Rig()
    rig.arm()
    bad = 0
    for values in (
        (6, 1, 9, 1, 300, 0, 0, 1000, 0),
        (255, 1, 9, 1, 300, 0, 0, 1000, 0),
        (codes.FORWARD, 4, 9, 1, 300, 0, 0, 1000, 0),
        (codes.DRIVE, 1, 9, 1, 300, 1001, 0, 1000, 0),
        (codes.DRIVE, 1, 9, 1, 300, 0, -1001, 1000, 0),
        (codes.FORWARD, 1, 9, 1, 300, 0, 0, 1001, 0),
    ):
        rig.send(messages.COMMAND, values)
        bad += 1
        rig.run(3)
        assert rig.neutral()
    rig.send(messages.ORDER, (99, 7, 1))
    rig.send(messages.CLEARANCE, clearance(0, 9, 0))
    rig.run(3)
    assert rig.app.link.incoming.bad == bad + 2
    kept(CORE, "P12", "values out of range")


def test_p12_frames_late_by_their_own_stamp_are_refused_but_a_late_stop_counts():
    rig = Rig()
    rig.arm()
    rig.host_alive = False
    stamp = rig.stamp
    rig.run(90)
    rig.stamp = stamp - 20
    rig.send(messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, 9, 1, 300, 0, 0, 1000, 0))
    rig.send(messages.ORDER, (codes.ARM, 99, 1))
    rig.run(5)
    assert rig.neutral()
    rig.host_alive = True
    rig.run(200)
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    rig.stamp = (rig.stamp - 500) & 0xFFFF
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, 0, 0, 0, 0, 1000, 0))
    rig.until(rig.neutral, 2)


def test_p12_a_recording_never_keeps_the_hosts_next_frames_out():
    # Recorded more than 128 frames ago, its number looks ahead of the newest; its stamp is old.
    for wait in (110, 1000):
        rig = Rig()
        rig.arm()
        rig.drive()
        rig.send(messages.PING, (1, 2))
        recorded = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
        rig.run(wait)
        while True:
            ahead = (recorded_seq(rig, recorded) - rig.encoder._seq) & 0xFF
            if 1 <= ahead <= 100:
                break
            rig.send(messages.PING, (3, 4))
            rig.one_ms()
        rig.wire.push(recorded, len(recorded))
        rig.send(messages.COMMAND, (codes.STOP, 0, 0, codes.DRIVER, 0, 0, 0, 1000, 0))
        rig.until(rig.neutral, 2)
    kept(CORE, "P12", "a recording never keeps the host's next frames out")


def recorded_seq(rig, recorded):
    decoder = frame.Decoder()
    decoder.session = rig.encoder.session
    for byte in recorded:
        if decoder.feed(byte):
            return decoder.buf[messages.SEQ_AT]
    raise AssertionError("not a frame of this session")
