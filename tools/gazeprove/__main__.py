"""The command line of tools/prove, inside its virtual environment."""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

from gazeprove.parts import PARTS
from gazesetup import note, say

_SHOWN = 20


def main(arguments: list[str]) -> int:
    """Run the proof; 0 when nothing fell short."""
    parser = argparse.ArgumentParser(
        prog="tools/prove", description="Proves the safety core; exits 1 when anything falls short."
    )
    parser.add_argument(
        "--quick", action="store_true", help="a sample of each part, under a minute"
    )
    parser.add_argument("--json", metavar="FILE", help="write the figures to FILE as JSON")
    parser.add_argument("--part", action="append", choices=list(PARTS), help="only this part")
    options = parser.parse_args(arguments)
    results: dict[str, Any] = {}
    short: list[str] = []
    for name in options.part or PARTS:
        started = time.monotonic()
        with say(name):
            figures, missing = PARTS[name](options.quick, note)
        results[name] = {**figures, "seconds": round(time.monotonic() - started, 1)}
        short += [f"{name}: {text}" for text in missing]
    for name, figures in results.items():
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in figures.items()))
    for text in short[:_SHOWN]:
        print(f"SHORT {text}")
    if len(short) > _SHOWN:
        print(f"SHORT and {len(short) - _SHOWN} more")
    print("PROVED" if not short else f"NOT PROVED: {len(short)} findings")
    if options.json:
        with open(options.json, "w") as file:
            json.dump({"quick": options.quick, "figures": results, "short": short}, file, indent=1)
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
