"""`python -m gazetwin`: the first prototype's published turns compared with the twin's."""

from __future__ import annotations

import argparse
from pathlib import Path

from gazesim.profiles import identified
from gazetwin import pictures, tables
from gazetwin.clues import match
from gazetwin.prototype import FITTED


def main() -> int:
    """Print the requested tables; 1 when the twin no longer reproduces every clue."""
    parser = argparse.ArgumentParser(prog="python -m gazetwin", description=__doc__)
    parser.add_argument("--plots", type=Path, metavar="FOLDER", help="write the plots there")
    options = parser.parse_args()
    turn = identified("4.1").turn
    found = match(turn, FITTED)
    print(f"The twin, gains read {FITTED.name}: {tables.chair(turn)}")
    print(tables.clues(found))
    print(f"\n{tables.profiles(turn, FITTED)}")
    if options.plots is not None:
        options.plots.mkdir(parents=True, exist_ok=True)
        pictures.experiments(options.plots, turn, FITTED)
        pictures.readings(options.plots, turn)
    return 0 if found.holds() else 1


raise SystemExit(main())
