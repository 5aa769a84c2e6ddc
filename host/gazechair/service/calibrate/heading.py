"""`gazechair calibrate heading`: calibrates the BNO055 on the board and stores the result."""

from __future__ import annotations

import contextlib
import json
import math
import time
from collections.abc import Callable
from typing import Any

from gazechair.commissioning.board_settings import BoardSettings, SettingRefused
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.service import board_connection
from gazechair.service.calibrate.driver_files import PROGRAM, driver_files
from gazechair.service.calibrate.program_repl import ProgramBoard, ProgramRepl
from gazechair.service.flash import FlashError
from gazechair.service.flash.command import find_port
from gazechair.service.flash.greeting import Greeter, wait_for_hello
from gazelink import codes

BUS, ADDRESS = 1, 0x28
SECONDS = (10, 600)
FOLDER = "/flash/calibrate"
STORED = "/flash/heading_offsets"  # the firmware's file
_HELLO_S = 3.0
_MAINTENANCE_S = 3.0
_START_S = 30.0
_STORE_S = 30.0
_ASK_AGAIN_S = 1.0
_CHIP_ID = 0xA0

_INSTRUCTIONS = (
    "gyro: let the sensor lie still until it says 3 of 3",
    "accelerometer: turn it slowly to six rests and hold it still in each for some seconds:",
    "flat, upside down, on each of its four edges; then flat again",
    "Ctrl-C ends it, and nothing is changed",
)


class HeadingCalibration:
    """One run. `say` gets each line for the user; `connect` opens a board's REPL by its path."""

    def __init__(
        self,
        say: Callable[[str], None],
        connect: Callable[[str], ProgramBoard] = ProgramRepl,
    ) -> None:
        self._say = say
        self._connect = connect
        self._calibrated = False
        self._trouble = ""
        self._before: bytes | None = None

    def run(self, port: str, seconds: int) -> None:
        """Calibrate the sensor of the board at `port` ("auto": find it) and store the result.

        The sensor gets `seconds` to become calibrated. Raises CalibrateError, FlashError or
        SettingsError; the board then runs its firmware with its previous calibration, unless the
        text says otherwise.
        """
        if not SECONDS[0] <= seconds <= SECONDS[1]:
            raise CalibrateError(f"--seconds must be {SECONDS[0]}..{SECONDS[1]}, not {seconds}")
        files = driver_files()
        path = find_port(port)
        self._enter_maintenance(path)
        try:
            self._at_board(path, lambda board: self._work(board, files, seconds))
            self._wait_for_firmware(path)
            self._judge(seconds)
            self._store(path)
        except BaseException:
            self._put_back(path)
            raise
        self._say("calibrated, and kept by the board: it gives it to the sensor at every start")

    def _enter_maintenance(self, path: str) -> None:
        greeter = Greeter(path)
        try:
            hello = greeter.hello(_HELLO_S)
            if hello is None:
                raise CalibrateError(
                    f"no gazechair firmware answers at {path}; stop gazechair run if it holds the"
                    " port, or run `gazechair flash` first"
                )
            if not hello.ours:
                raise CalibrateError(
                    f"the board at {path} has firmware {hello.version} of another table; run"
                    " `gazechair flash` first"
                )
            if hello.armed:
                raise CalibrateError(f"the board at {path} is armed; disarm it first")
            greeter.enter_maintenance(_MAINTENANCE_S)
        finally:
            greeter.close()
        self._say(f"{path}: the firmware left for maintenance: neutral, enable line off")

    # Whatever happens at the board, it is reset, so that its firmware runs again.
    def _at_board(self, path: str, work: Callable[[ProgramBoard], None]) -> None:
        board = self._connect(path)
        try:
            board.feed_watchdog()
            work(board)
        finally:
            board.reset()

    def _work(self, board: ProgramBoard, files: dict[str, bytes], seconds: int) -> None:
        try:
            board.remove(FOLDER)
            board.make_folder(FOLDER)
            for folder in sorted({path.rpartition("/")[0] for path in files} - {""}):
                board.make_folder(f"{FOLDER}/{folder}")
            for path, content in files.items():
                board.write(f"{FOLDER}/{path}", content)
            self._say("Adafruit's driver is on the board; it resets the sensor")
            for line in _INSTRUCTIONS:
                self._say(line)
            board.program(
                f"import sys\nsys.path.insert(0, {FOLDER!r})\n"
                f"from {PROGRAM} import run\nrun({BUS}, {ADDRESS}, {seconds})",
                self._take_line,
            )
        except BaseException:
            with contextlib.suppress(FlashError):
                board.remove(FOLDER)
            raise
        board.remove(FOLDER)
        if self._calibrated:
            # Else the firmware would give the sensor its older calibration at its start.
            self._before = board.read(STORED)
            board.remove(STORED)

    def _take_line(self, line: str) -> None:
        try:
            result: dict[str, Any] = json.loads(line)
        except ValueError:
            return
        if "error" in result:
            self._trouble = self._trouble or (
                f"the heading sensor at {ADDRESS:#04x} does not answer as it should"
                f" ({result['error']}); check its supply, SDA, SCL and pull-ups"
            )
        elif "chip_id" in result:
            chip_id = result["chip_id"]
            self._say(f"chip id {chip_id:#04x} (a BNO055 says {_CHIP_ID:#04x})")
            if chip_id != _CHIP_ID:
                self._trouble = f"what answers at {ADDRESS:#04x} is no BNO055 ({chip_id:#04x})"
        else:
            _, gyro, accelerometer, _ = result["calibration"]
            self._calibrated = gyro == accelerometer == 3
            self._say(
                f"heading {-(result['heading'] or 0.0) % 360.0:5.1f} deg, turning"
                f" {math.degrees(result['gyro_z'] or 0.0):+6.1f} deg/s (left is positive),"
                f" gyro {gyro} of 3, accelerometer {accelerometer} of 3"
            )

    def _wait_for_firmware(self, path: str) -> None:
        hello, trouble = wait_for_hello(path, _START_S)
        if hello is None:
            raise CalibrateError(
                f"the firmware at {path} does not come back ({trouble}); run `gazechair flash`"
            )
        self._say(f"{hello.name} runs its firmware again")

    def _judge(self, seconds: int) -> None:
        if self._trouble:
            raise CalibrateError(self._trouble)
        if not self._calibrated:
            raise CalibrateError(
                f"not calibrated within {seconds} s, nothing was stored; repeat, with more"
                " --seconds or longer rests"
            )

    def _store(self, path: str) -> None:
        with board_connection.connected(path) as board:
            self._ask_to_store(board)

    # Its fusion restarts with the firmware, so the sensor may need a while to report 3 again.
    def _ask_to_store(self, board: BoardSettings) -> None:
        self._say("asking the firmware to store it; let the sensor lie still")
        end_s = time.monotonic() + _STORE_S
        while True:
            try:
                board.save_heading()
                return
            except SettingRefused as refusal:
                if refusal.reason != codes.SENSOR_NOT_CALIBRATED:
                    raise
                if time.monotonic() > end_s:
                    raise CalibrateError(
                        "the firmware did not store it (sensor_not_calibrated): the sensor lost"
                        " its calibration when the firmware started; nothing changed, repeat"
                    ) from None
            time.sleep(_ASK_AGAIN_S)

    def _put_back(self, path: str) -> None:
        before = self._before
        if before is None:
            return
        try:
            self._wait_for_firmware(path)  # it may have been reset a moment ago
            self._enter_maintenance(path)
            self._at_board(path, lambda board: board.write(STORED, before))
            self._wait_for_firmware(path)
        except (FlashError, CalibrateError, KeyboardInterrupt) as error:
            why = str(error) or "stopped"
            raise CalibrateError(
                f"nothing was stored, and the calibration before could not be put back ({why});"
                " repeat the calibration"
            ) from None
        self._say("the calibration before is back")
