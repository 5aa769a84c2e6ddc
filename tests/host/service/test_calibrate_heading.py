"""`gazechair calibrate heading` with a board in memory: its requests, results and leftovers."""

import contextlib
import json
import subprocess
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest

import gazesetup
from fakeboardfiles import FakeBoardFiles
from gazeboard.boards import pins
from gazeboard.io import imu
from gazechair import cli
from gazechair.commissioning.board_settings import SettingRefused, SettingsError
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.service.calibrate import driver_files, heading
from gazechair.service.calibrate.heading import HeadingCalibration
from gazechair.service.flash import FlashError
from gazechair.service.flash.greeting import Hello
from gazelink import codes, frame

pytest.importorskip("adafruit_bno055", reason="needs the extra bench: pip install gazechair[bench]")

OLDER = b"an older calibration"


def report(gyro: int, accelerometer: int) -> str:
    """A line of the program on the board, turned 90 degrees to the left."""
    calibration = [0, gyro, accelerometer, 0]
    return json.dumps({"heading": 270.0, "gyro_z": 0.5, "calibration": calibration})


CHIP = '{"chip_id": 160}'


class MemoryBoard(FakeBoardFiles):
    """Everything that the calibration communicates with: greeter, REPL, the firmware's settings."""

    def __init__(self) -> None:
        super().__init__()
        self.says = [CHIP, report(3, 1), report(3, 3)]
        self.dies: BaseException | None = None
        self.dies_removing = False  # the stored calibration; it is gone by then
        self.hello: Hello | None = Hello("teensy40", "", frame.schema_hash(), True, False, 1)
        self.comes_back = True
        self.stops_waiting = 0  # at so many of the waits for the firmware the user types Ctrl-C
        self.refusals = 0  # to come; then it stores
        self.refusal: SettingsError = SettingRefused("refused", codes.SENSOR_NOT_CALIBRATED)
        self.maintenances = 0
        self.asked = 0
        self.present: list[str] = []  # files while the program ran
        self.stored_at_start: list[bytes | None] = []

    def program(self, code: str, on_line: Callable[[str], None]) -> None:
        self.present = sorted(path for path in self.files if path.startswith(heading.FOLDER))
        assert f"run({pins.IMU_BUS}, {imu.ADDRESS}, 60)" in code
        for line in self.says:
            on_line(line)
        if self.dies is not None:
            raise self.dies

    def remove(self, path: str) -> None:
        super().remove(path)
        if path == heading.STORED and self.dies_removing:
            self.dies_removing = False
            raise KeyboardInterrupt

    def save_heading(self) -> None:
        self.asked += 1
        if self.refusals:
            self.refusals -= 1
            raise self.refusal

    def wait_for_hello(self, path: str, limit_s: float) -> tuple[Hello | None, str]:
        self.stored_at_start.append(self.files.get(heading.STORED))
        if self.stops_waiting:
            self.stops_waiting -= 1
            raise KeyboardInterrupt
        return (self.hello, "") if self.comes_back else (None, "it says nothing")


@pytest.fixture
def board(monkeypatch: pytest.MonkeyPatch) -> Iterator[MemoryBoard]:
    made = MemoryBoard()

    def enter_maintenance(_timeout_s: float) -> None:
        made.maintenances += 1

    greeter = SimpleNamespace(
        hello=lambda _: made.hello, enter_maintenance=enter_maintenance, close=lambda: None
    )

    @contextlib.contextmanager
    def connected(_port: str) -> Iterator[MemoryBoard]:
        yield made

    clock = SimpleNamespace(now_s=0.0)

    def sleep(duration_s: float) -> None:
        clock.now_s += duration_s

    monkeypatch.setattr(Hello, "ours", property(lambda hello: hello.schema_hash != 0))
    monkeypatch.setattr(heading, "Greeter", lambda path: greeter)
    monkeypatch.setattr(heading, "wait_for_hello", made.wait_for_hello)
    monkeypatch.setattr(heading, "board_connection", SimpleNamespace(connected=connected))
    time = SimpleNamespace(monotonic=lambda: clock.now_s, sleep=sleep)
    monkeypatch.setattr(heading, "time", time)
    yield made
    assert not [path for path in made.files if path.startswith(heading.FOLDER)]
    assert heading.FOLDER not in made.made
    assert made.resets == made.maintenances, "the firmware runs again"


def run(board: MemoryBoard) -> str:
    lines: list[str] = []
    try:
        HeadingCalibration(lines.append, lambda path: board).run("/dev/board", 60)
    finally:
        print("\n".join(lines))
    return "\n".join(lines)


def test_its_bus_and_address_are_the_firmwares() -> None:
    assert (heading.BUS, heading.ADDRESS) == (pins.IMU_BUS, imu.ADDRESS)


def test_a_calibrated_sensor_is_stored_by_the_firmware(board: MemoryBoard) -> None:
    printed = run(board)
    assert "chip id 0xa0" in printed
    assert "heading  90.0 deg, turning  +28.6 deg/s" in printed, "counter-clockwise positive"
    assert "gyro 3 of 3, accelerometer 1 of 3" in printed
    assert "lie still" in printed
    assert "six rests" in printed
    assert "kept by the board" in printed
    assert board.asked == 1
    assert len(board.present) == 6
    assert board.feeds, "the firmware's watchdog would end it"


def test_the_older_calibration_is_not_given_back_before_the_new_is_stored(
    board: MemoryBoard,
) -> None:
    board.files[heading.STORED] = OLDER
    run(board)
    assert board.stored_at_start == [None]


def test_the_firmware_gets_time_until_the_sensor_is_calibrated_again(board: MemoryBoard) -> None:
    board.refusals = 5
    assert "kept by the board" in run(board)
    assert board.asked == 6


@pytest.mark.parametrize("older", [OLDER, None])
def test_a_refusal_is_said_plainly_and_the_older_one_is_back(
    board: MemoryBoard, older: bytes | None
) -> None:
    if older:
        board.files[heading.STORED] = older
    board.refusals = 1000
    with pytest.raises(CalibrateError, match=r"did not store it .sensor_not_calibrated.*repeat"):
        run(board)
    assert board.files.get(heading.STORED) == older


def test_another_refusal_ends_it_at_once(board: MemoryBoard) -> None:
    board.files[heading.STORED] = OLDER
    board.refusals = 1
    board.refusal = SettingRefused("driving is on", codes.SETTING_WHILE_ARMED)
    with pytest.raises(SettingsError, match="driving is on"):
        run(board)
    assert board.asked == 1
    assert board.files[heading.STORED] == OLDER


def test_a_firmware_that_stays_away_is_said_with_what_was_lost(board: MemoryBoard) -> None:
    board.comes_back = False
    with pytest.raises(CalibrateError, match=r"does not come back .* run `gazechair flash`"):
        run(board)
    board.files[heading.STORED] = OLDER
    with pytest.raises(CalibrateError, match="calibration before could not be put back"):
        run(board)


@pytest.mark.parametrize(
    ("says", "reason"),
    [
        ([CHIP, report(3, 2), report(3, 2)], "not calibrated within 60 s, nothing was stored"),
        ([CHIP, report(0, 3)], "not calibrated within 60 s"),
        ([CHIP, report(3, 3), report(2, 3)], "not calibrated within 60 s"),
        ([CHIP], "not calibrated within 60 s"),
        (['{"chip_id": 85}', '{"error": "bad chip id"}'], r"is no BNO055 \(0x55\)"),
        (['{"error": "[Errno 19] ENODEV"}'], "ENODEV.*check its supply, SDA, SCL"),
        ([CHIP, report(3, 1), '{"error": "[Errno 5] EIO"}'], "EIO.*check its supply"),
        (["nonsense", "", "{"], "not calibrated within 60 s"),
    ],
)
def test_a_sensor_that_is_not_calibrated_keeps_what_is_stored(
    board: MemoryBoard, says: list[str], reason: str
) -> None:
    board.files[heading.STORED] = OLDER
    board.says = says
    with pytest.raises(CalibrateError, match=reason):
        run(board)
    assert board.asked == 0
    assert board.files[heading.STORED] == OLDER


@pytest.mark.parametrize("end", [FlashError("cable"), KeyboardInterrupt()])
def test_whatever_ends_the_program_the_board_is_cleaned_and_reset(
    board: MemoryBoard, end: BaseException
) -> None:
    board.files[heading.STORED] = OLDER
    board.dies = end
    with pytest.raises(type(end)):
        run(board)
    assert board.resets == 1
    assert board.files[heading.STORED] == OLDER


def test_an_end_while_the_older_one_is_removed_puts_it_back(board: MemoryBoard) -> None:
    board.files[heading.STORED] = OLDER
    board.dies_removing = True
    with pytest.raises(KeyboardInterrupt):
        run(board)
    assert board.files[heading.STORED] == OLDER
    assert board.stored_at_start == [None, OLDER], "the reset firmware is waited for both times"


def test_a_second_ctrl_c_while_the_older_one_is_put_back_is_said_with_what_was_lost(
    board: MemoryBoard,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    board.files[heading.STORED] = OLDER
    board.stops_waiting = 2
    made = HeadingCalibration(lambda _: None, lambda path: board)
    monkeypatch.setattr(heading, "HeadingCalibration", lambda say: made)
    assert cli.main(["calibrate", "heading", "--port", "/dev/board", "--seconds", "60"]) == 2
    assert heading.STORED not in board.files
    printed = capsys.readouterr().err
    assert "calibration before could not be put back (stopped); repeat the calibration" in printed
    assert "keeps" not in printed


@pytest.mark.parametrize(
    ("hello", "reason"),
    [
        (None, "no gazechair firmware answers at /dev/board; .*run `gazechair flash` first"),
        (Hello("teensy40", "0.0.7", 0, True, False, 1), "firmware 0.0.7 of another table"),
        (Hello("teensy40", "", 1, True, True, 1), "is armed; disarm it first"),
    ],
)
def test_such_a_board_is_left_alone(board: MemoryBoard, hello: Hello | None, reason: str) -> None:
    board.hello = hello
    with pytest.raises(CalibrateError, match=reason):
        run(board)
    assert not board.changes
    assert not board.maintenances


def test_the_missing_driver_is_said_before_anything_happens(
    board: MemoryBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(driver_files._DRIVER, "adafruit_nothing.here", "nothing.py")
    with pytest.raises(CalibrateError, match=r"pip install 'gazechair\[bench\]'"):
        run(board)
    assert not board.maintenances


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["heading", "--seconds", "3"], "--seconds must be 10..600, not 3"),
        (["heading", "--port", "/none/here"], "/none/here"),
        (["joystick", "--port", "/none/here"], "no board:"),
    ],
)
def test_the_command_line_refuses_in_one_line(
    words: list[str],
    reason: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gazechair.service.board_connection._CONNECT_S", 0.3)
    assert cli.main(["calibrate", *words]) == 2
    printed = capsys.readouterr().err
    assert printed.startswith("gazechair: ")
    assert reason in printed
    assert printed.count("\n") == 1


SHIM_CHECK = """
import sys
class Machine: pass
sys.modules['machine'] = Machine
from board_program import BusioShape
class Bus:
    fails = 2
    def writeto(self, address, data, stop=True):
        if Bus.fails:
            Bus.fails -= 1
            raise OSError(19)
        print('write', address, bytes(data), stop)
    def readfrom_into(self, address, into):
        print('read', address, len(into))
        into[0] = 160
bus = BusioShape(Bus())
assert bus.try_lock()
bus.writeto(40, b'abcd', start=1, end=3)
both = bytearray(b'xyz')
bus.writeto_then_readfrom(40, both, both, out_end=1, in_start=1)
bus.readfrom_into(40, both, start=2)
bus.unlock()
print(bytes(both))
"""


def test_the_shape_that_the_driver_sees_runs_on_micropython(
    micropython: gazesetup.MicroPython,
) -> None:
    """Slices by keyword, a repeated start, and patience while the sensor resets."""
    folder = gazesetup.ROOT / "host" / "gazechair" / "service" / "calibrate"
    environment = {"MICROPYPATH": str(folder)}
    words = [str(micropython.path), "-c", SHIM_CHECK]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=60, env=environment)
    assert ended.stdout.splitlines() == [
        "write 40 b'bc' True",
        "write 40 b'x' False",
        "read 40 2",
        "read 40 1",
        r"b'x\xa0\xa0'",
    ], ended.stderr
