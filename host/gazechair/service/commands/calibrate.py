"""The command `gazechair calibrate heading | joystick | camera`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from gazechair.base.user_error import UserError
from gazechair.config import configuration


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    calibrate = commands.add_parser("calibrate", help="calibrate a part of the chair")
    parts = calibrate.add_subparsers(title="parts", required=True, metavar="PART")
    heading = parts.add_parser("heading", help="the heading sensor, on the board")
    heading.add_argument(
        "--seconds", type=int, default=180, metavar="N", help="give up after N (default: 180)"
    )
    heading.set_defaults(act=_heading)
    joystick = parts.add_parser("joystick", help="the joystick's neutral, with a meter")
    joystick.set_defaults(act=_joystick)
    camera = parts.add_parser("camera", help="the camera's pose above the floor, by marks on it")
    camera.add_argument(
        "--picture",
        type=Path,
        metavar="JPEG",
        help="save a picture here; with --marks: the marks' picture",
    )
    camera.add_argument(
        "--marks", type=Path, metavar="FILE", help="a line for each mark: pixels u v, metres x y"
    )
    for name, dest, unit, what in (
        ("height", "height_m", "M", "height of the camera above the floor"),
        ("down", "down_deg", "DEG", "angle by which the camera looks down"),
        ("field", "field_deg", "DEG", "angle of view of the picture's width"),
    ):
        text = f"{what}; an estimate is enough"
        camera.add_argument(f"--{name}", dest=dest, type=float, metavar=unit, help=text)
    configuration.add_option(camera)
    camera.set_defaults(act=_camera)
    for part in (heading, joystick):
        part.add_argument("--port", default="auto", help="the board's serial port")


def _heading(options: argparse.Namespace) -> int:
    from gazechair.service.calibrate.heading import HeadingCalibration
    from gazechair.service.flash import FlashError

    try:
        HeadingCalibration(lambda line: print(line, flush=True)).run(options.port, options.seconds)
    except FlashError as error:
        raise UserError(str(error)) from None
    except KeyboardInterrupt:
        raise UserError("stopped; the board keeps the calibration it had") from None
    return 0


def _joystick(options: argparse.Namespace) -> int:
    from gazechair.commissioning.calibrate.joystick import JoystickCalibration
    from gazechair.service import board_connection

    try:
        with board_connection.connected(options.port) as board:
            JoystickCalibration(
                board, lambda line: print(line, flush=True), sys.stdin.readline
            ).run()
    except KeyboardInterrupt:
        raise UserError("stopped; the neutral counts are as before") from None
    return 0


def _camera(options: argparse.Namespace) -> int:
    from gazechair.commissioning.calibrate.marks import ByEye
    from gazechair.service.calibrate import camera

    config = configuration.load(options.config)
    seen = {name: getattr(options, name) for name in ("height_m", "down_deg", "field_deg")}
    try:
        if options.marks and not options.picture:
            raise UserError("--marks needs the --picture that they are in")
        if options.marks:
            eye = ByEye(**{name: one for name, one in seen.items() if one is not None})
            camera.store(config, options.picture, options.marks, eye, print)
        elif options.picture:
            camera.take_picture(config, options.picture, print)
        else:
            camera.show(config, print)
    except KeyboardInterrupt:
        raise UserError("stopped; nothing was changed") from None
    return 0
