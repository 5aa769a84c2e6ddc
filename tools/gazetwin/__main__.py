"""`python -m gazetwin`: the first prototype's published turns compared with the twin's."""

from __future__ import annotations

import argparse
from pathlib import Path

from gazesim.profiles import identified
from gazetwin import pictures, tables
from gazetwin.clues import match
from gazetwin.fit import search, slices
from gazetwin.prototype import FITTED, READINGS


def main() -> int:
    """Print the requested tables; 1 when the twin no longer reproduces every clue."""
    parser = argparse.ArgumentParser(prog="python -m gazetwin", description=__doc__)
    parser.add_argument(
        "--plots", type=Path, metavar="FOLDER", help="write the plots there (minutes)"
    )
    parser.add_argument(
        "--fit",
        type=float,
        metavar="SECONDS",
        help="also search again for the chair behind the clues, that long for each reading",
    )
    options = parser.parse_args()
    turn = identified("4.1").turn
    found = match(turn, FITTED)
    print(f"The twin, gains read {FITTED.name}: {tables.chair(turn)}")
    print(tables.clues(found))
    print(f"\n{tables.profiles(turn, FITTED)}")
    if options.plots is not None:
        options.plots.mkdir(parents=True, exist_ok=True)
        around = slices(turn, FITTED)
        print(f"\n{tables.slices(around, turn)}")
        pictures.experiments(options.plots, turn, FITTED)
        pictures.readings(options.plots, turn)
        pictures.costs(options.plots, around, turn)
    if options.fit is not None:
        for reading in READINGS:
            print(f"\n{tables.fitted(reading, search(reading, options.fit))}")
    return 0 if found.holds() else 1


raise SystemExit(main())
