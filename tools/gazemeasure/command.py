"""The command `gazechair measure NAME`."""

from __future__ import annotations

import argparse
from typing import Any

from gazechair.cli import refuse
from gazemeasure import benchmarks


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    measure = commands.add_parser("measure", help="run a benchmark on the simulated chair")
    measure.add_argument("name", help="which one; an unknown name lists them")
    measure.add_argument("--quick", action="store_true", help="fewer samples")
    measure.add_argument("--json", action="store_true", help="print one line of JSON")
    measure.set_defaults(act=_measure)


def _measure(options: argparse.Namespace) -> int:
    if options.name not in benchmarks.BENCHMARKS:
        known = "; ".join(f"{name}: {row[1]}" for name, row in benchmarks.BENCHMARKS.items())
        return refuse(f"no benchmark {options.name!r}; there are {known}")
    try:
        report = benchmarks.run(options.name, options.quick)
    except ImportError as error:
        return refuse(f"measure needs the extras sim and test: {error}")
    print(report.json() if options.json else report.table())
    return 0 if report.ok else 1
