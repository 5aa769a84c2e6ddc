"""The command `gazechair bench`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from gazechair.base.user_error import UserError


def add(commands: Any) -> None:
    """Add it to argparse's subparsers `commands`."""
    bench = commands.add_parser("bench", help="check the wiring on a Linux I2C bus, no Teensy")
    bench.add_argument("--bus", type=int, required=True, metavar="N", help="N of /dev/i2c-N")
    bench.add_argument("--json", action="store_true", help="print one line of JSON")
    bench.add_argument(
        "--yes-db9-is-unplugged", action="store_true", help="sweep the wipers without asking"
    )
    bench.set_defaults(act=_bench)


def _bench(options: argparse.Namespace) -> int:
    from gazechair.service.bench.bench import Bench
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
    except (KeyboardInterrupt, EOFError):
        raise UserError("stopped") from None
    if options.json:
        print(bench.as_json())
    return 0 if good else 1
