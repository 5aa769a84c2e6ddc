"""The command `gazechair plugin list | check NAME | new NAME`."""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from gazechair.cli import refuse
from gazechair.plugins.describe import describe
from gazechair.plugins.found import Found, installed


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    plugin = commands.add_parser("plugin", help="inputs and modes: list, check, create")
    acts = plugin.add_subparsers(title="actions", required=True, metavar="ACTION")
    shown = acts.add_parser("list", help="list what is installed, with every setting")
    shown.set_defaults(act=_list)
    check = acts.add_parser("check", help="run the contract tests in the virtual chair")
    check.add_argument("name", help="as in the list; input.NAME or mode.NAME when both exist")
    check.add_argument("--json", action="store_true", help="print one line of JSON")
    check.set_defaults(act=_check)
    new = acts.add_parser("new", help="create a package to start from")
    new.add_argument("name")
    new.add_argument("--kind", choices=("input", "mode"), default="input")
    new.add_argument("--folder", type=Path, default=Path(), help="where (default: here)")
    new.set_defaults(act=_new)


def _list(_options: argparse.Namespace) -> int:
    found = installed()
    with ThreadPoolExecutor(4) as pool:
        for one, description in zip(found, pool.map(describe, found), strict=True):
            print(
                f"{one.kind}.{one.name} ({one.package}): {description.about or description.wrong}"
            )
            print("".join(f"    {line}\n" for line in description.table))
    if not found:
        print("no input and no mode is installed")
    return 0


def _check(options: argparse.Namespace) -> int:
    fitting = [one for one in installed() if options.name in (one.name, f"{one.kind}.{one.name}")]
    if len(fitting) != 1:
        titles = ", ".join(f"{one.kind}.{one.name}" for one in fitting or installed())
        return refuse(f"{'which' if fitting else 'no'} {options.name!r}; there are: {titles}")
    try:
        return _run(fitting[0], options.json)
    except ImportError as error:
        return refuse(f"plugin check needs the simulator: {error}")


def _run(found: Found, as_json: bool) -> int:
    from gazecontract.contract import Contract

    rows = []
    for row in Contract(found).rows():
        rows.append(row)
        if not as_json:
            print(f"{'ok   ' if row.ok else 'FAILS'} {row.rule}: {row.saw}", flush=True)
    passed = all(row.ok for row in rows)
    if as_json:
        print(json.dumps({"ok": passed, "rows": [vars(row) for row in rows]}))
    return 0 if passed else 1


def _new(options: argparse.Namespace) -> int:
    from gazecontract import template

    try:
        place = template.write(options.kind, options.name, options.folder)
    except (ValueError, OSError) as error:
        return refuse(f"plugin new: {error}")
    print(f"written: {place}\npip install -e {place}")
    print(f"gazechair plugin check {options.kind}.{options.name}")
    print(f"in the configuration: [{options.kind}.{options.name}]")
    return 0
