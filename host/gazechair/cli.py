"""The command line: `gazechair run` and every other command; `gazechair --help` lists them.

Other packages add commands by an entry point of the group `gazechair.commands`: a function that
takes argparse's subparsers.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
import threading
from collections.abc import Sequence
from importlib.metadata import entry_points
from pathlib import Path

from gazechair.alerts import command as alert_command
from gazechair.base.version import version
from gazechair.blackbox import command as log_command
from gazechair.config import configuration
from gazechair.config.configuration import ConfigError
from gazechair.sensing.mapping import command as map_command
from gazechair.service import hotspot, lidar_cli
from gazelink.settings_table import PROFILES

_SWITCH_S = 0.001  # 0.005 by default
_COMMANDS = "gazechair.commands"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; its exit code: 0 well, 1 the doctor found a failure, 2 cannot run."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.act(options))
    except ConfigError as error:
        return refuse(str(error))


class _Version(argparse.Action):
    # Wait for git only when somebody needs the version.
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"gazechair {version()}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gazechair", description="Drive a power wheelchair with the eyes."
    )
    parser.add_argument(
        "--version", action=_Version, nargs=0, help="show the version and its commit"
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run the host: board, lidar, camera, driver's page")
    run.set_defaults(act=_run)
    doctor = commands.add_parser("doctor", help="check this machine and say what to do")
    doctor.add_argument("--json", action="store_true", help="print the findings as JSON")
    doctor.set_defaults(act=_doctor)
    for command in (run, doctor):
        command.add_argument(
            "--config",
            type=Path,
            metavar="FILE",
            help="configuration file (default: the one that $GAZECHAIR_CONFIG names, or none)",
        )
    pair = commands.add_parser("pair", help="let a tablet or phone in, list them, send one away")
    pair.add_argument(
        "--role",
        choices=("driver", "caretaker", "viewer"),
        default="driver",
        help="what the device may do (default: driver)",
    )
    pair.add_argument("--list", action="store_true", help="show the paired devices")
    pair.add_argument("--revoke", metavar="ID", help="send a device away")
    pair.add_argument(
        "--config", type=Path, metavar="FILE", help="the configuration of gazechair run"
    )
    pair.set_defaults(act=_pair)
    settings = commands.add_parser("settings", help="read and change the board's settings")
    settings.add_argument("--port", default="auto", help="the board's serial port")
    settings.add_argument("--set", nargs=2, action="append", metavar=("NAME", "VALUE"))
    settings.add_argument("--defaults", action="store_true", help="first take all defaults")
    settings.add_argument("--save", action="store_true", help="keep them across a reset")
    settings.add_argument(
        "--save-heading", action="store_true", help="keep the heading sensor's calibration"
    )
    settings.set_defaults(act=_settings)
    flash = commands.add_parser("flash", help="put the firmware on the board")
    flash.add_argument("--port", default="auto", help="the board's serial port (default: find it)")
    flash.add_argument("--dry-run", action="store_true", help="only say what would be done")
    flash.add_argument("--force", action="store_true", help="flash in spite of doubts")
    flash.set_defaults(act=_flash)
    bench = commands.add_parser("bench", help="check the wiring on a Linux I2C bus, no Teensy")
    bench.add_argument("--bus", type=int, required=True, metavar="N", help="N of /dev/i2c-N")
    bench.add_argument("--json", action="store_true", help="print one line of JSON")
    bench.add_argument(
        "--yes-db9-is-unplugged", action="store_true", help="sweep the wipers without asking"
    )
    bench.set_defaults(act=_bench)
    calibrate = commands.add_parser("calibrate", help="calibrate a part of the chair")
    parts = calibrate.add_subparsers(title="parts", required=True, metavar="PART")
    heading = parts.add_parser("heading", help="the heading sensor, on the board")
    heading.add_argument(
        "--seconds", type=int, default=180, metavar="N", help="give up after N (default: 180)"
    )
    heading.set_defaults(act=_calibrate_heading)
    joystick = parts.add_parser("joystick", help="the joystick's neutral, with a meter")
    joystick.set_defaults(act=_calibrate_joystick)
    camera = parts.add_parser("camera", help="where the camera sits over the floor, by marks on it")
    camera.add_argument(
        "--picture", type=Path, metavar="JPEG", help="take it; with --marks: use it"
    )
    camera.add_argument(
        "--marks", type=Path, metavar="FILE", help="a line for each mark: pixels u v, metres x y"
    )
    for name, dest, unit in (
        ("height", "height_m", "M"),
        ("down", "down_deg", "DEG"),
        ("field", "field_deg", "DEG"),
    ):
        text = "the camera's, by eye; a guess will do"
        camera.add_argument(f"--{name}", dest=dest, type=float, metavar=unit, help=text)
    camera.add_argument("--config", type=Path, metavar="FILE", help="configuration file")
    camera.set_defaults(act=_calibrate_camera)
    for part in (heading, joystick):
        part.add_argument("--port", default="auto", help="the board's serial port")
    tune = commands.add_parser("tune", help="find out how the chair turns, in one speed profile")
    tune.add_argument("--profile", required=True, choices=PROFILES, help="selected on the chair")
    tune.add_argument("--config", type=Path, metavar="FILE", help="configuration file")
    tune.add_argument("--dry-run", action="store_true", help="only show what it finds")
    tune.set_defaults(act=_tune)
    lidar_cli.add(commands)
    hotspot.add(commands)
    log_command.add(commands)
    alert_command.add(commands)
    map_command.add(commands)
    config = commands.add_parser("config", help="print a configuration file with all defaults")
    config.set_defaults(act=_config)
    for added in sorted(entry_points(group=_COMMANDS), key=lambda entry: entry.name):
        try:
            added.load()(commands)
        except Exception as error:  # code from outside; the other commands continue
            refuse(f"the command {added.name} of {added.value} cannot be loaded: {error}")
    return parser


def _run(options: argparse.Namespace) -> int:
    # Imported late: `gazechair config` works with the standard library alone.
    from gazechair.base.service_manager import ServiceManager
    from gazechair.base.throttled_log import ThrottledLog
    from gazechair.daemon import Daemon
    from gazechair.web import WebError

    manager = ServiceManager()
    daemon = Daemon(configuration.load(options.config))
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(name)s: %(message)s")
    threading.excepthook = ThrottledLog(logging.getLogger("gazechair.threads")).thread_ended
    # A thread that waits for its turn in Python waits this long for each that is before it.
    sys.setswitchinterval(_SWITCH_S)
    # No Event: its lock may be taken by the very thread that a signal interrupts.
    ends, ending = os.pipe()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os.write(ending, b"."))
    try:
        daemon.start()
    except WebError as error:
        return refuse(str(error))
    try:
        print(f"gazechair: the driver's page is at {daemon.url}", flush=True)
        if invitation := daemon.invitation():
            print(invitation, flush=True)
        manager.ready(daemon.url)
        while not select.select([ends], [], [], manager.pace_s)[0]:
            if daemon.alive:
                manager.alive()
        manager.ending()
    finally:
        daemon.stop()
    return 0


def _pair(options: argparse.Namespace) -> int:
    from gazechair.base.state_folder import state_folder
    from gazechair.service import pair

    folder = state_folder(configuration.load(options.config).web.state_folder)
    try:
        if options.revoke:
            pair.revoke(folder, options.revoke, print)
        elif options.list:
            pair.show_devices(folder, print)
        else:
            pair.make_code(folder, options.role, print)
    except pair.PairError as error:
        return refuse(str(error))
    return 0


def _doctor(options: argparse.Namespace) -> int:
    from gazechair.service import doctor

    findings = doctor.examine(options.config)
    print(doctor.as_json(findings) if options.json else doctor.as_text(findings))
    return 1 if doctor.failed(findings) else 0


def _settings(options: argparse.Namespace) -> int:
    from gazechair.service import board_settings

    try:
        changes = [board_settings.parse(name, text) for name, text in options.set or ()]
        with board_settings.connected(options.port) as board:
            if options.defaults:
                board.defaults()
            for index, value in changes:
                board.set(index, value)
            if options.save:
                board.save()
            if options.save_heading:
                board.save_heading()
            print(board_settings.as_text(board.all()))
    except board_settings.SettingsError as error:
        return refuse(str(error))
    return 0


def _flash(options: argparse.Namespace) -> int:
    from gazechair.service.flash import Flasher, FlashError

    try:
        Flasher(lambda line: print(line, flush=True)).flash(
            options.port, options.dry_run, options.force
        )
    except FlashError as error:
        return refuse(str(error))
    return 0


def _bench(options: argparse.Namespace) -> int:
    from gazechair.service.bench import Bench, BenchError
    from gazechair.service.bench.bus import LinuxBus

    def ask(question: str) -> str:
        return input(question) if sys.stdin.isatty() and not options.json else ""

    def say(line: str) -> None:
        print(line, file=sys.stderr if options.json else sys.stdout, flush=True)

    try:
        bus = LinuxBus(options.bus)
        try:
            bench = Bench(bus, say, ask)
            good = bench.run(options.yes_db9_is_unplugged)
        finally:
            bus.close()
    except BenchError as error:
        return refuse(str(error))
    except (KeyboardInterrupt, EOFError):
        return refuse("stopped")
    if options.json:
        print(bench.as_json())
    return 0 if good else 1


def _calibrate_heading(options: argparse.Namespace) -> int:
    from gazechair.service.board_settings import SettingsError
    from gazechair.service.calibrate import CalibrateError, HeadingCalibration
    from gazechair.service.flash import FlashError

    try:
        HeadingCalibration(lambda line: print(line, flush=True)).run(options.port, options.seconds)
    except (CalibrateError, FlashError, SettingsError) as error:
        return refuse(str(error))
    except KeyboardInterrupt:
        return refuse("stopped; the board keeps the calibration it had")
    return 0


def _calibrate_joystick(options: argparse.Namespace) -> int:
    from gazechair.service import board_settings
    from gazechair.service.calibrate import CalibrateError, JoystickCalibration

    try:
        with board_settings.connected(options.port) as board:
            JoystickCalibration(
                board, lambda line: print(line, flush=True), sys.stdin.readline
            ).run()
    except (CalibrateError, board_settings.SettingsError) as error:
        return refuse(str(error))
    except KeyboardInterrupt:
        return refuse("stopped; the neutral counts are as before")
    return 0


def _calibrate_camera(options: argparse.Namespace) -> int:
    from gazechair.service.calibrate import CalibrateError, camera
    from gazechair.service.calibrate.marks import ByEye

    config = configuration.load(options.config)
    seen = {name: getattr(options, name) for name in ("height_m", "down_deg", "field_deg")}
    try:
        if options.marks and not options.picture:
            raise CalibrateError("--marks needs the --picture that they are in")
        if options.marks:
            eye = ByEye(**{name: one for name, one in seen.items() if one is not None})
            camera.store(config, options.picture, options.marks, eye, print)
        elif options.picture:
            camera.take_picture(config, options.picture, print)
        else:
            camera.show(config, print)
    except CalibrateError as error:
        return refuse(str(error))
    except KeyboardInterrupt:
        return refuse("stopped; nothing was changed")
    return 0


def _tune(options: argparse.Namespace) -> int:
    from gazechair.service.board_settings import SettingsError
    from gazechair.service.tune.errors import TuneError
    from gazechair.service.tune.session import tune

    settings = configuration.load(options.config)
    try:
        tune(settings, options.profile, options.dry_run, lambda line: print(line, flush=True))
    except (SettingsError, TuneError) as error:
        return refuse(str(error))
    except KeyboardInterrupt:
        return refuse("stopped; nothing was changed")
    return 0


def _config(options: argparse.Namespace) -> int:
    print(configuration.annotated_default(), end="")
    return 0


def refuse(line: str) -> int:
    """Say in one line why a command cannot do what it was asked for; its exit code."""
    print(f"gazechair: {line}", file=sys.stderr)
    return 2
