"""The command `gazechair replay FILE`."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from gazechair.cli import refuse


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    replay = commands.add_parser(
        "replay", help="replay a recorded drive through the safety core and compare every decision"
    )
    replay.add_argument("file", type=Path, help="a file of the log, with the board's trace")
    replay.add_argument(
        "--as-test", metavar="NAME", help="store it as a test, in tests/drives of this checkout"
    )
    replay.add_argument(
        "--view", type=Path, metavar="SVG", help="draw the drive from above; works for any log"
    )
    replay.set_defaults(act=_replay)


def _replay(options: argparse.Namespace) -> int:
    try:
        from gazechair.blackbox.reader import LogFile, of_this_version
        from gazereplay import as_test, view
        from gazereplay.replay import replay
        from gazereplay.result import NoTrace
    except ImportError as error:
        return refuse(f"replay needs an extra: pip install 'gazechair[log]' ({error})")
    try:
        ending = ""
        if options.view:
            file = LogFile(options.file)
            file.check()
            with of_this_version(options.file):
                drive = view.follow(file.lines())
            ending = file.ending()
            if not drive.events:
                return refuse(f"{options.file} has no state of a board to draw. {ending}".strip())
            view.draw(drive, options.view)
            print(f"drawn in {options.view}")
        with of_this_version(options.file):
            result = replay(options.file)
    except OSError as error:
        return refuse(f"{error.filename or options.file}: {error.strerror}")
    except NoTrace as error:
        if options.view and not options.as_test:
            print(f"decisions are not checked: {error}")
            return 0
        return refuse(f"{options.file}: {error}")
    print(
        f"{result.ticks} ticks, {result.armed} of them driving; {result.decisions} decisions,"
        f" compared in {result.compared} ticks;"
        f" {result.lives} start{'s' if result.lives > 1 else ''} of the board"
    )
    if result.gaps:
        gaps = f"{result.gaps} gap{'s' if result.gaps > 1 else ''}"
        print(f"{gaps}: {result.unchecked} ticks not checked, as the trace lacks what they took")
    if ending := ending or result.ending:
        print(ending)
    if result.unnamed:
        print("this log does not name its board's version, which may have another core than this")
    if result.difference is not None:
        moment = time.strftime("%H:%M:%S", time.localtime(result.difference.at_ns // 10**9))
        print(f"differs first at {moment}, {result.difference}")
        return 1
    print("all decisions are the same")
    if options.as_test:
        try:
            print(f"kept as {as_test.keep(options.file, options.as_test)}")
        except (OSError, ValueError) as error:
            return refuse(str(error))
    return 0
