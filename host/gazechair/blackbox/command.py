"""The commands `gazechair log list`, `show` and `export`."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gazechair.base.state_folder import state_folder
from gazechair.base.user_error import UserError
from gazechair.config import configuration

if TYPE_CHECKING:
    from gazechair.blackbox.reader import LogFile


def add(commands: Any) -> None:
    """Add them to argparse's subparsers `commands`."""
    log = commands.add_parser("log", help="read the black box")
    acts = log.add_subparsers(title="actions", required=True, metavar="ACTION")
    listed = acts.add_parser("list", help="list the files: when, how long, how large")
    shown = acts.add_parser("show", help="print what happened, in words")
    exported = acts.add_parser("export", help="print everything as JSON lines or CSV")
    exported.add_argument("--format", choices=("jsonl", "csv"), default="jsonl")
    exported.add_argument("--topic", help="only this one, for example /board/state")
    for command in (listed, shown, exported):
        configuration.add_option(command)
    for command in (shown, exported):
        command.add_argument(
            "file", nargs="?", help="number, name or path of a file (default: the newest)"
        )
    listed.set_defaults(act=lambda options: _act(_list, options))
    shown.set_defaults(act=lambda options: _act(_show, options))
    exported.set_defaults(act=lambda options: _act(_export, options))


def chosen(folder: Path, wanted: str | None) -> Path:
    """The file for a path, a name or a number; None: the newest in `folder`."""
    from gazechair.blackbox.writer import files

    if wanted is not None and Path(wanted).is_file():
        return Path(wanted)
    found = files(folder)
    if wanted is not None:
        number = wanted.zfill(6)
        found = [path for path in found if wanted == path.name or path.name[:6] == number]
    if not found:
        what = "no file" if wanted is None else f"no file {wanted}"
        raise UserError(f"{folder} has {what}; gazechair log list shows those there are")
    return found[-1]


def _folder_of(options: argparse.Namespace) -> Path:
    """Where the files of the configured host are."""
    return state_folder(configuration.load(options.config).web.state_folder) / "log"


def _act(act: Any, options: argparse.Namespace) -> int:
    try:
        importlib.import_module("mcap_ros2")
    except ImportError:
        raise UserError("the log needs an extra: pip install 'gazechair[log]'") from None
    try:
        act(options)
        sys.stdout.flush()
    except BrokenPipeError:  # as of `| head`
        sys.stderr.close()
    except OSError as error:
        raise UserError(str(error)) from None
    return 0


def _list(options: argparse.Namespace) -> None:
    from gazechair.blackbox.reader import LogFile
    from gazechair.blackbox.writer import files

    folder = _folder_of(options)
    total = 0
    for path in files(folder):
        file = LogFile(path)
        try:
            length_s = file.length_s()
            ending = file.ending()
            size = path.stat().st_size
        except OSError as error:
            print(f"{path.name}  {error.strerror}")
            continue
        total += size
        print(f"{path.name}  {length_s:7.0f} s  {size / 1e6:8.1f} MB")
        if ending:
            print(f"  {ending}")
    print(f"{folder}: {total / 1e6:.1f} MB")


def _print_ending(file: LogFile) -> None:
    """On stderr, where no program takes it for data."""
    if ending := file.ending():
        sys.stdout.flush()
        print(f"gazechair: {ending}", file=sys.stderr)


def _show(options: argparse.Namespace) -> None:
    from gazechair.blackbox.export import story
    from gazechair.blackbox.reader import LogFile, of_this_version

    file = LogFile(chosen(_folder_of(options), options.file))
    file.check()
    with of_this_version(file.path):
        for line in story(file.lines()):
            print(line)
    _print_ending(file)


def _export(options: argparse.Namespace) -> None:
    from gazechair.blackbox.export import as_csv, as_json_lines
    from gazechair.blackbox.reader import Line, LogFile

    file = LogFile(chosen(_folder_of(options), options.file))
    wanted = options.topic
    if options.format == "csv" and wanted is None:
        raise UserError("a table is of one topic: --topic /board/state")
    file.check()
    topics: set[str] = set()

    def lines() -> Iterator[Line]:
        for line in file.lines():
            topics.add(line.topic)
            if wanted in (None, line.topic):
                yield line

    if options.format == "csv":
        as_csv(lines(), sys.stdout)
    else:
        as_json_lines(lines(), sys.stdout)
    if wanted is not None and wanted not in topics:
        there = ", ".join(sorted(topics)) or "no messages at all"
        problem = f"{file.path} has no message of {wanted}; there are {there}"
        raise UserError("; ".join(filter(None, (problem, file.ending()))))
    _print_ending(file)
