"""The command line of tools/prove, inside its virtual environment."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from typing import Any

from gazeprove import faster, record
from gazeprove.parts import PARTS
from gazesetup import note, say

_SHOWN = 20


def main(arguments: list[str]) -> int:
    """Run the proof; 0 when nothing fell short."""
    parser = argparse.ArgumentParser(
        prog="tools/prove",
        description="Proves the safety core; exits 1 when anything falls short."
        " Writes what it found into docs/proof.json, unless --quick.",
    )
    parser.add_argument("--quick", action="store_true", help="a sample of each part")
    parser.add_argument(
        "--changed", action="store_true", help="only parts that docs/proof.json does not prove"
    )
    parser.add_argument("--json", metavar="FILE", help="write the figures to FILE as JSON")
    parser.add_argument("--part", action="append", choices=list(PARTS), help="only this part")
    options = parser.parse_args(arguments)
    results: dict[str, Any] = {}
    short: list[str] = []
    for name in options.part or PARTS:
        if options.changed and not record.why_not_now(name):
            note(f"{name}: proven, and nothing changed since")
            continue
        results[name], missing = _run(name, options.quick)
        short += [f"{name}: {text}" for text in missing]
    for name, figures in results.items():
        totals = {key: value for key, value in figures.items() if not isinstance(value, list)}
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in totals.items()))
    for text in short[:_SHOWN]:
        print(f"SHORT {text}")
    if len(short) > _SHOWN:
        print(f"SHORT and {len(short) - _SHOWN} more")
    print("PROVED" if not short else f"NOT PROVED: {len(short)} findings")
    if options.json:
        with open(options.json, "w") as file:
            json.dump({"quick": options.quick, "figures": results, "short": short}, file, indent=1)
    return 1 if short else 0


def _run(name: str, quick: bool) -> tuple[dict[str, Any], list[str]]:
    """One part: its figures and what fell short; the full form goes into the record."""
    files = record.files_of(name)
    started, used = time.monotonic(), _processor_s()
    with say(name):
        found, short = faster.run(name, quick, note)
    figures = {
        **found,
        "seconds": round(time.monotonic() - started, 1),
        "processor_seconds": round(_processor_s() - used, 1),
    }
    if record.files_of(name) != files:
        short = [*short, "a file changed while it was being proven"]
    if not quick:
        record.write(name, figures, short, files)
    return figures, short


def _processor_s() -> float:
    """Time of this process and of those that it waited for."""
    return sum(os.times()[:4])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
