# What is stored, on a flash that loses its power, refuses, or holds anything at all: the board
# starts, with defaults and a fault, and an emergency stands.

import json
import os

from fakeflash import Flash, PowerCut, files_on, real
from gazeboard.io import bootlog, storage
from gazeboard.io.settings import Settings
from gazeboard.io.storage import UNREADABLE, Files, sealed
from gazelink import codes
from gazesim.board_rig import Rig
from promiserig import armed, ask, fault, toggles
from promises import CORE, kept

NAMES = ("settings.json", "emergency", "watchdog_boots", "heading_offsets")
_DEEP = "[" * 3000


def noise(length, seed):
    data = bytearray(length)
    for k in range(length):
        seed = (seed * 1103515245 + 12345) & 0x3FFFFFFF
        data[k] = seed >> 16 & 0xFF
    return bytes(data)


def patterns():
    yield b""
    yield b"\n"
    yield b"\0" * 40
    for length in (1, 4, 100, 4096):
        yield b"\xff" * length
    yield b"\xc3\x28"  # no UTF-8
    yield b"\xe2\x82"
    yield "é²٣".encode()
    yield b"9" * 5000
    yield b"-1"
    yield b"{" * 20000
    yield noise(60000, 5)
    for seed in range(60):
        yield noise(seed * 7 % 90 + 1, seed + 1)
    for line in (_DEEP, "null", "[]", "1.0", '{"profile": 1e400}', '{"profile": true}', '{"": 1}'):
        yield sealed(line).encode()
    for line in ("", "x", "-3", "1.5", "9999", "zz" * 22, "0" * 43, '{"profile": []}'):
        yield sealed(line).encode()
    whole = Settings().text().encode()
    for cut in range(0, len(whole), 97):
        yield whole[:cut]
    for at in range(0, len(whole), 131):
        yield whole[:at] + bytes((whole[at] ^ 0x80,)) + whole[at + 1 :]


EXPECTED = {
    "settings.json": codes.CALIBRATION,
    "emergency": codes.EMERGENCY,
    "watchdog_boots": codes.STORAGE,
    "heading_offsets": codes.STORAGE,
}


def started(files):
    # As main.py does it.
    rig = Rig(files=files)
    damaged = bootlog.damaged(rig.board)
    count = bootlog.watchdog_boots(rig.board)
    assert count < bootlog.LIMIT
    return rig, damaged


def test_the_board_starts_whatever_a_file_holds():
    flash = Flash()
    files = files_on(flash)
    try:
        for name in NAMES:
            for data in patterns():
                flash.data.clear()
                flash.put(name, data)
                rig, damaged = started(files)
                rig.run(3)
                bit = EXPECTED[name]
                assert fault(rig, bit) or (damaged and bit == codes.STORAGE), (name, data[:20])
                assert rig.app.settings.get(0) == 170
                assert not armed(rig)
    finally:
        real()
    kept(CORE, "P11", "whatever stands in its file: the latch counts")


def test_damaged_files_keep_it_from_arming_until_the_caretaker_clears():
    flash = Flash()
    files = files_on(flash)
    try:
        for name in ("emergency", "heading_offsets"):
            flash.data.clear()
            flash.put(name, b"\xff" * 50)
            rig = Rig(files=files)
            rig.run(1300)
            rig.give(codes.ARM)
            rig.run(300)
            assert not armed(rig)
            assert toggles(rig, 20) == 0
            rig.give(codes.RESET_FAULTS, codes.CARETAKER)
            rig.run(200)
            rig.arm()
            rig = Rig(files=files)
            rig.arm()  # the next start knows nothing of it
    finally:
        real()


def test_real_files_with_any_bytes_are_read_or_unreadable():
    folder = "board-storage-test"
    try:
        os.mkdir(folder)
    except OSError:
        pass
    files = Files(folder)
    assert files.load("absent") is None
    files.store("a", "text\n")
    assert files.load("a") == "text\n"
    for data in patterns():
        with open(folder + "/a", "wb") as f:
            f.write(data)
        text = files.load("a")
        good = data and len(data) <= storage.SIZE_MAX and max(data) < 128
        assert text == (data.decode() if good else UNREADABLE), data[:20]
    files.remove("a")
    files.remove("a")
    assert files.load("a") is None
    os.mkdir(folder + "/a")  # what is no file
    assert files.load("a") == UNREADABLE
    os.rmdir(folder + "/a")
    os.rmdir(folder)


# Every state of the flash that a power cut during `act` can leave.
def cuts(flash, act):
    before = dict(flash.data)
    at = 0
    while True:
        at += 1
        flash.data = dict(before)
        flash.again()
        flash.cut_at = at
        try:
            act()
            return
        except PowerCut:
            flash.again()
            yield at


def test_a_power_cut_leaves_the_old_file_or_the_new():
    flash = Flash()
    files = files_on(flash)
    try:
        files.store("settings.json", "old")
        seen = set()
        for at in cuts(flash, lambda: files.store("settings.json", "new and longer")):
            assert files.load("settings.json") == "old", at
            seen.add(at)
        assert len(seen) == 3  # open, write, rename
        assert files.load("settings.json") == "new and longer"
        for _ in cuts(flash, lambda: files.remove("settings.json")):
            assert files.load("settings.json") == "new and longer"
        assert files.load("settings.json") is None
    finally:
        real()


def test_a_power_cut_while_latching_or_clearing_leaves_one_or_the_other():
    flash = Flash()
    files = files_on(flash)
    try:
        rig = Rig(files=files)
        latch = rig.app._latch
        rig.run(5)
        assert not latch.stored
        for wanted in (True, False):
            count = 0
            for _ in cuts(flash, lambda: latch_uncaught(rig, wanted)):
                after = Rig(files=files)
                assert fault(after, codes.EMERGENCY) == (not wanted)
                count += 1
            assert count >= 3
            flash.again()
            assert fault(Rig(files=files), codes.EMERGENCY) == wanted
    finally:
        real()


# What the latch does until the power is lost. It catches what the flash raises; a board without
# power does nothing more.
def latch_uncaught(rig, wanted):
    cut = []
    latch = rig.app._latch
    latch._board = Gone(rig.board, cut)
    latch._proven(wanted)
    latch._board = rig.board
    if cut:
        raise PowerCut


class Gone:
    def __init__(self, board, cut):
        self._board = board
        self._cut = cut

    def load(self, name):
        return self._do(self._board.load, name)

    def store(self, *args):
        return self._do(self._board.store, *args)

    def remove(self, *args):
        return self._do(self._board.remove, *args)

    def _do(self, call, *args):
        if self._cut:
            raise PowerCut
        try:
            return call(*args)
        except PowerCut:
            self._cut.append(True)
            raise


def press_emergency(rig):
    rig.give(codes.EMERGENCY_STOP)
    rig.until(lambda: fault(rig, codes.EMERGENCY), 60)
    rig.release()
    rig.run(40)


def test_p11_the_latch_stands_after_a_reset_though_the_flash_is_full():
    flash = Flash()
    files = files_on(flash)
    try:
        rig = Rig(files=files)
        rig.drive()
        flash.full = True
        press_emergency(rig)
        for full in (True, False):
            flash.full = full
            rig.boot()
            rig.run(1300)
            assert fault(rig, codes.EMERGENCY)
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(200)
        rig.arm()
        rig.boot()
        rig.arm()
        kept(CORE, "P11", "latched though the flash is full")
    finally:
        real()


def test_p11_a_flash_that_takes_nothing_keeps_it_disarmed_until_it_is_proven():
    flash = Flash()
    files = files_on(flash)
    try:
        rig = Rig(files=files)
        rig.drive()
        flash.dead = True
        press_emergency(rig)
        rig.run(1000)
        assert fault(rig, codes.STORAGE)
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(1300)
        assert fault(rig, codes.STORAGE)  # whatever the caretaker clears
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        rig.boot()  # and after a reset: a flash that takes nothing is found at the start
        rig.run(1300)
        assert fault(rig, codes.STORAGE)
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        flash.dead = False
        rig.until(lambda: not rig.app._latch.failed, 70000)
        rig.run(100)
        assert fault(rig, codes.STORAGE)  # latched
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(200)
        rig.arm()
        kept(CORE, "P11", "a flash that takes nothing: disarmed until it does")
    finally:
        real()


def test_p11_a_refused_latch_is_tried_again_ever_more_seldom():
    flash = Flash()
    files = files_on(flash)
    try:
        rig = Rig(files=files)
        rig.arm()
        flash.dead = True
        tried = []
        store = files.store
        files.store = lambda name, text: (tried.append(rig.now_ms), store(name, text))
        press_emergency(rig)
        rig.run(20000)
        gaps = [tried[k + 1] - tried[k] for k in range(len(tried) - 1)]
        assert 4 <= len(gaps) < 10
        for k in range(len(gaps) - 1):
            assert gaps[k + 1] >= 2 * gaps[k] - 2
        flash.dead = False
        rig.until(lambda: not rig.app._latch.failed, 70000)
        rig.boot()
        assert fault(rig, codes.EMERGENCY)
    finally:
        real()


def test_a_reset_of_the_latch_that_the_flash_refuses_is_tried_again():
    flash = Flash()
    files = files_on(flash)
    try:
        rig = Rig(files=files)
        rig.arm()
        press_emergency(rig)
        flash.dead = True
        rig.run(600)
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(700)
        assert fault(rig, codes.STORAGE)
        rig.boot()
        assert fault(rig, codes.EMERGENCY)  # never lost, at worst cleared twice
        flash.dead = False
        rig.run(1300)
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(500)
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(100)
        rig.arm()
    finally:
        real()


def test_whatever_the_flash_raises_the_service_loop_goes_on():
    for error in (OSError(28), OSError(5), MemoryError(), ValueError("spoilt")):
        flash = Flash()
        files = files_on(flash)
        try:
            rig = Rig(files=files)
            rig.arm()

            def refuse(*_args):
                raise error

            files.store = files.remove = refuse
            press_emergency(rig)
            assert ask(rig, codes.SETTING_SAVE)[1] == codes.SETTING_NOT_STORED
            rig.run(500)
            assert fault(rig, codes.STORAGE)
            assert rig.state["first_fault"]
        finally:
            real()


def test_json_in_the_settings_file_may_be_anything():
    for text in (_DEEP, '{"a": ' * 900, "[1, 2", json.dumps({"profile": 10**30})):
        settings = Settings(sealed(text))
        assert not settings.calibrated
        assert settings.error
        assert settings.profile == 2


def test_a_neutral_that_was_loaded_is_the_stored_one():
    text = Settings().text().replace("170", "175").split("\n")[0]
    settings = Settings(sealed(text))
    assert settings.neutral() == (175, 175)
    settings.drop_neutral()
    assert settings.neutral() == (175, 175)
    assert settings.calibrated
