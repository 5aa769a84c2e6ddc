# Watchdog resets in a row are counted across boots; the last words reach any host.

from gazeboard.io import bootlog
from gazelink import codes, frame, messages
from gazesim.board_rig import Rig


def boot_with(rig, cause):
    rig.board.reset_cause = cause
    return bootlog.watchdog_boots(rig.board)


def test_three_watchdog_boots_in_a_row_are_counted():
    rig = Rig()
    assert [boot_with(rig, 3) for _ in range(3)] == [1, 2, 3]
    assert bootlog.LIMIT == 3


def test_any_other_boot_starts_the_count_anew():
    for cause in (1, 5):
        rig = Rig()
        boot_with(rig, 3)
        boot_with(rig, 3)
        assert boot_with(rig, cause) == 0
        assert boot_with(rig, 3) == 1


def test_a_spoilt_count_file_is_a_first_time():
    rig = Rig()
    rig.files.texts["watchdog_boots"] = "a lot"
    assert boot_with(rig, 3) == 1


def test_the_last_words_need_no_session():
    rig = Rig()
    reason = codes.FAULT_REASON + codes.WATCHDOG_BOOTS
    assert bootlog.send_fault(rig.board, reason, "because " * 10)
    decoder = frame.Decoder()
    good = [decoder.feed(rig.wire.sent[k]) for k in range(rig.wire.count)]
    assert good[-1]
    words = messages.FAULT.unpack(decoder.buf)
    assert words["reason"] == reason
    assert words["detail"] == (b"because " * 10)[:40]


def test_a_line_that_takes_nothing_is_given_up():
    rig = Rig()
    rig.wire.reading = False
    assert not bootlog.send_fault(rig.board, 1, "nobody listens", 100)


def test_last_words_are_repeated_until_somebody_answers():
    rig = Rig()
    said = []

    class Line:
        def read_byte(self):
            rig.clock.now_us += 100000
            return 13 if len(said) == 3 else -1

        def write_some(self, buf, start, end):
            if start < end:
                said.append(bytes(buf[start:end]))
            return end

    rig.board.serial = Line()
    bootlog.last_words(rig.board, codes.FAULT_REASON + codes.NO_HARD_TIMER, "why")
    assert len(said) == 3


def test_an_hour_without_one_forgets_the_resets():
    rig = Rig()
    for _ in range(5):
        assert boot_with(rig, 3) == 1  # a year apart
        rig.boot()
        rig.run(1200)
        rig.app.outbox.ticks = 3600000 - 1450
        rig.arm()  # 1.5 s
        assert "watchdog_boots" in rig.files.texts  # a flash write stops the tick: not while armed
        rig.give(codes.DISARM)
        rig.run(50)
        assert "watchdog_boots" not in rig.files.texts


def test_a_flash_that_refuses_the_count_does_not_stop_the_start():
    rig = Rig()

    def refuse(*_args):
        raise OSError(28)

    rig.files.store = rig.files.remove = refuse
    for cause in (3, 1, 3):
        boot_with(rig, cause)
    rig.files.texts["watchdog_boots"] = "spoilt"
    assert bootlog.damaged(rig.board)
    assert boot_with(rig, 1) == 0
    rig.app.outbox.ticks = 3600000
    rig.run(5)


class Talk:
    # A line to a board that says its last words: `said` are the bytes it hears, one each 2 ms.
    def __init__(self, rig, said):
        self._rig = rig
        self._said = list(said)
        self.heard = 0

    def read_byte(self):
        self._rig.clock.now_us += 2000
        return self._said.pop(0) if self._said else -1

    def write_some(self, _buf, _start, end):
        self.heard += 1
        assert self.heard < 100
        return end


def framed(message, values):
    encoder = frame.Encoder()
    message.pack(encoder.body, values)
    n = encoder.finish(message, 0)
    return bytes(encoder.wire[:n])


HELLO = framed(messages.HELLO, (0, 0, frame.schema_hash(), 77, 0, 0, 1, 0, b"host"))
REASON = codes.FAULT_REASON + codes.WATCHDOG_BOOTS
KEY = messages.MAINTENANCE_KEY


def last_words(said, button=1):
    rig = Rig()
    rig.board.button_pin = lambda: button
    rig.board.serial = Talk(rig, said)
    return bootlog.last_words(rig.board, REASON, "why")


def test_the_caretakers_clear_ends_the_last_words():
    clear = framed(messages.MAINTENANCE, (KEY, 0, REASON))
    assert last_words(HELLO * 20 + clear + HELLO) == bootlog.CLEARED


def test_three_seconds_at_the_chairs_button_end_them_too():
    assert last_words(b"", 0) == bootlog.CLEARED


def test_a_host_that_greets_or_talks_nonsense_opens_no_repl():
    wrong = framed(messages.MAINTENANCE, (KEY ^ 1, 0, REASON))
    assert last_words(HELLO * 30 + wrong + b"\x05\x03nonsense\0" + b"\r") == bootlog.OPENED
    rig = Rig()
    line = Talk(rig, HELLO * 30 + wrong + b"\x05\x03non\rsense\0" + HELLO * 30 + b"\r\x03")
    rig.board.serial = line
    assert bootlog.last_words(rig.board, REASON, "why") == bootlog.OPENED
    assert line._said == [3]  # mpremote's own bytes reach the REPL


def test_maintenance_opens_the_repl():
    for reason in (0, REASON + 1):
        said = framed(messages.MAINTENANCE, (KEY, 0, reason))
        assert last_words(said) == bootlog.OPENED


def test_a_late_clear_leaves_a_running_board_running():
    rig = Rig()
    rig.run(100)
    bad = rig.app.link.incoming.bad
    rig.send(messages.MAINTENANCE, (KEY, 0, REASON))
    rig.run(3)
    assert not rig.app.link.maintenance
    assert rig.app.link.incoming.bad == bad + 1
    rig.send(messages.MAINTENANCE, (KEY, 0, codes.NO_REASON))
    rig.run(3)
    assert rig.app.link.maintenance
