"""`gazechair calibrate` against the emulated Teensy: Adafruit's driver runs there, wipers move."""

from collections.abc import Callable, Iterator

import pytest

from gazeboard.io.imu import OFFSETS_SIZE
from gazeboard.io.storage import sealed
from gazechair.commissioning.board_settings import SettingsError
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.commissioning.calibrate.joystick import JoystickCalibration
from gazechair.service import board_connection
from gazechair.service.calibrate import heading
from gazechair.service.calibrate.heading import HeadingCalibration
from gazechair.service.flash.greeting import Greeter, wait_for_hello
from gazechair.service.flash.repl import Repl
from liveboard import LIMIT_S, NEUTRAL, EmulatedLiveBoard

# By one process, which flashes its first board once for all of them.
pytestmark = [pytest.mark.m7, pytest.mark.recorded, pytest.mark.xdist_group("board")]

CALIBRATED = 0b11_11_11_00  # register 0x35, the magnetometer not used
GYRO_ONLY = 0b11_11_00_00
OLDER = sealed("0b" * OFFSETS_SIZE).encode()


class Bench:
    """Someone at the sensor of a running board, and what they were told."""

    def __init__(self, board: EmulatedLiveBoard) -> None:
        self.board = board
        self.path = str(board.host.path)
        self.lines: list[str] = []
        self.on_line: Callable[[str], None] = lambda _: None

    def sensor_says(self, calibration: int) -> None:
        """In its register 0x35, from the next sample on."""
        self.board.world.imu._calibration = lambda: calibration

    def _say(self, line: str) -> None:
        print(line)
        self.lines.append(line)
        self.on_line(line)

    def calibrate(self, seconds: int = 10) -> None:
        HeadingCalibration(self._say).run(self.path, seconds)

    def in_repl(self, act: Callable[[Repl], None]) -> None:
        """`act` in the REPL of a board that runs its firmware; then it runs again."""
        greeter = Greeter(self.path)
        try:
            assert greeter.hello(LIMIT_S)
            greeter.enter_maintenance(LIMIT_S)
        finally:
            greeter.close()
        repl = Repl(self.path)
        try:
            act(repl)
        finally:
            repl.reset()
            self.comes_back()

    def comes_back(self) -> None:
        """The firmware runs after a reset, during which the port vanishes."""
        hello, trouble = wait_for_hello(self.path, LIMIT_S)
        assert hello, trouble

    def left_behind(self) -> tuple[bool, bytes | None]:
        """Whether the temporary folder is there, and the stored calibration."""
        found: list[tuple[bool, bytes | None]] = []

        def look(repl: Repl) -> None:
            found.append(("calibrate" in repl.folders("/flash"), repl.read(heading.STORED)))

        self.in_repl(look)
        return found[0]


@pytest.fixture
def bench(emulated: EmulatedLiveBoard) -> Iterator[Bench]:
    """Time passes in the background."""
    emulated.connect()
    emulated.start_background()
    try:
        yield Bench(emulated)
    finally:
        emulated.stop_background()


def test_a_calibrated_sensor_is_kept_by_the_firmware_itself(bench: Bench) -> None:
    bench.in_repl(lambda repl: repl.write(heading.STORED, OLDER))
    bench.sensor_says(GYRO_ONLY)

    def rest(line: str) -> None:
        if "accelerometer 0 of 3" in line:
            bench.sensor_says(CALIBRATED)

    bench.on_line = rest
    bench.calibrate()
    printed = "\n".join(bench.lines)
    assert "chip id 0xa0" in printed
    assert "gyro 3 of 3, accelerometer 0 of 3" in printed
    assert "gyro 3 of 3, accelerometer 3 of 3" in printed
    assert "kept by the board" in printed
    folder, stored = bench.left_behind()
    assert not folder
    assert stored is not None
    assert len(stored.splitlines()[0]) == 2 * 22, "the offsets of the sensor in hex, not the older"


def test_a_firmware_that_refuses_keeps_the_older_one(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(heading, "_STORE_S", 0.5)
    bench.in_repl(lambda repl: repl.write(heading.STORED, OLDER))
    bench.sensor_says(CALIBRATED)

    def lose(line: str) -> None:
        if "accelerometer 3 of 3" in line:
            bench.sensor_says(0)

    bench.on_line = lose
    with pytest.raises(CalibrateError, match="sensor_not_calibrated"):
        bench.calibrate()
    assert "the calibration before is back" in bench.lines
    assert bench.left_behind() == (False, OLDER)


def test_ctrl_c_and_a_dead_sensor_leave_nothing_behind(bench: Bench) -> None:
    bench.sensor_says(GYRO_ONLY)

    def interrupt(line: str) -> None:
        if line.startswith("heading"):
            raise KeyboardInterrupt

    bench.on_line = interrupt
    with pytest.raises(KeyboardInterrupt):
        bench.calibrate(seconds=600)
    bench.comes_back()
    bench.on_line = lambda _: None
    bench.board.world.imu.set_nak(True)
    with pytest.raises(CalibrateError, match=r"does not answer as it should .*; check its supply"):
        bench.calibrate()
    assert bench.left_behind() == (False, None)


def test_the_joystick_is_moved_saved_and_put_back(bench: Bench) -> None:
    def calibrate(*words: str) -> tuple[list[tuple[int, int]], str]:
        """Where the wipers were at each of these answers, and how it ended ("": saved)."""
        given, wipers = iter(words), []

        def read_line() -> str:
            wipers.append(bench.board.real_wipers)
            return next(given) + "\n"

        with board_connection.connected(bench.path) as board:
            try:
                JoystickCalibration(board, print, read_line).run()
            except (CalibrateError, SettingsError) as error:
                return wipers, str(error)
        return wipers, ""

    def undisturbed(end: str, at_end: tuple[int, int], *words: str) -> tuple[int, int]:
        """A PC that stalls in between loses the session, and the board what was set in it.

        Returns where the wipers were at first.
        """
        first: tuple[int, int] = bench.board.real_wipers
        for _ in range(20):
            wipers, ended = calibrate(*words)
            if ended == end and wipers[-1] == at_end:
                return first
        pytest.fail(f"ended with {wipers} and {ended!r}")

    as_before = "not saved; the counts are as before"
    undisturbed(as_before, (175, 169), "unplugged", "175", "ok", "-", "quit")
    # The same in each attempt, also in one after another that was saved.
    first = undisturbed("", (171, 160), "unplugged", "171", "ok", "160", "ok", "save")
    assert first == NEUTRAL, "put back before"
    bench.in_repl(lambda repl: None)  # a reset
    with board_connection.connected(bench.path) as board:
        assert board.all()[:2] == [171, 160]
