"""The command line of tools/docs, inside its virtual environment."""

from __future__ import annotations

import argparse
import sys

from gazehouse import drawing, failures, hazards, numbers, rooms
from gazesetup import ROOT

PAGES = {
    numbers.DOCUMENT: numbers.render,
    drawing.DOCUMENT: drawing.render,
    rooms.DOCUMENT: rooms.render,
    failures.DOCUMENT: failures.render,
    hazards.DOCUMENT: hazards.render,
}


def main(arguments: list[str] | None = None) -> int:
    """0: written, or up to date; 1: one is stale (--check)."""
    parser = argparse.ArgumentParser(prog="tools/docs", description="Pages made from the code.")
    parser.add_argument("--check", action="store_true", help="write nothing; 1 when one is stale")
    check = parser.parse_args(arguments).check
    stale = 0
    for document, render in PAGES.items():
        text = render()
        if not document.exists() or document.read_text() != text:
            stale += 1
            print(
                f"{document.relative_to(ROOT)} {'is stale: run tools/docs' if check else 'written'}"
            )
            if not check:
                document.write_text(text)
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
