"""Plots autotune and benchmark for docs/turning-lab.md: `python -m gazemeasure.turn.plots`."""

from __future__ import annotations

import random
from pathlib import Path

from gazechair.commissioning.tune.identify import identify
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazelink.settings_table import PROFILES
from gazemeasure.turn import jobs
from gazemeasure.turn.board import settings_with
from gazemeasure.turn.bound import best
from gazemeasure.turn.cases import Drawn
from gazemeasure.turn.jobs import LIMIT_MS
from gazemeasure.turn.judge import Turn
from gazemeasure.turn.model import Case
from gazemeasure.turn.plain import tuned
from gazemeasure.turn.rivals import PlainTurn, PrototypeTurn, turn_of_rival
from gazemeasure.turn.run import turn_of_board
from gazemeasure.turn.tuning import record
from gazesim.chair import Chair
from gazesim.imu_model import Imu, ImuErrors
from gazesim.profiles import random_chair, undisturbed
from gazetwin.prototype import FITTED
from gazetwin.svg import Line, Plot, write

_FOLDER = Path(__file__).resolve().parents[3] / "docs" / "turning"
_SECONDS = 4.0
_EVERY_MS = 10


def main() -> None:
    """Write both files."""
    _FOLDER.mkdir(exist_ok=True)
    write(_FOLDER / "turns.svg", [_turns("1.2"), _turns("3.1")])
    write(_FOLDER / "tune.svg", [_tune("3.1", 11)])


def _turns(profile: str) -> Plot:
    """A turn of ten degrees by all four on the undisturbed chair."""
    drawn = Drawn(profile, Case(undisturbed(profile), 10.0))
    rows = jobs.tune(drawn).rows(profile)
    values = {"profile": PROFILES.index(profile), "step_turn_limit_ms": LIMIT_MS}
    ours = turn_of_board(_chair(drawn), drawn.imu(), settings_with(values | rows), 10.0, 4000)
    plain = turn_of_rival(_chair(drawn), drawn.imu(), PlainTurn(tuned(profile)), 10.0, _SECONDS)
    first = turn_of_rival(_chair(drawn), drawn.imu(), PrototypeTurn(FITTED), 10.0, _SECONDS)
    return Plot(
        f"10 degrees to the left, profile {profile}, undisturbed",
        "s since the press",
        "heading, degrees",
        [
            _line("ours, tuned", ours),
            Line("time-optimal bound", *_bang_bang(drawn)),
            _line("plain PID, best gains", plain),
            _line("first prototype's PID", first),
        ],
        band=(9.0, 11.0),
        x_range=(0.0, _SECONDS),
        y_range=(0.0, 16.0),  # leaves room for the legend
    )


def _chair(drawn: Drawn) -> Chair:
    return Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)


def _line(name: str, turn: Turn) -> Line:
    headings = turn.heading_deg[::_EVERY_MS].tolist()
    return Line(name, [k * _EVERY_MS / 1000 for k in range(len(headings))], headings)


def _bang_bang(drawn: Drawn) -> tuple[list[float], list[float]]:
    """The twin's turn with the two switches that the bound found."""
    _, switches = best([drawn.case])
    first, second = switches[0, 0], switches[0].sum()
    chair = _chair(drawn)
    chair.step(0.001, (0.0, 0.0))
    times, headings = [], []
    for ms in range(round(_SECONDS * 1000)):
        if ms % _EVERY_MS == 0:
            times.append(ms / 1000)
            headings.append(chair.heading_deg)
        now = ms / 1000
        chair.step(0.001, (0.0, 1.0 if now < first else -1.0 if now < second else 0.0))
    return times, headings


def _tune(profile: str, seed: int) -> Plot:
    """The pulses of one tuning of a chair drawn at random, one after the other."""
    imu = Imu(ImuErrors.drawn(random.Random(seed)), seed)
    chair = Chair(profile, seed, random_chair(profile, seed))
    recordings = record(chair, imu, settings_with({}), profile)
    fit = identify(recordings, TurnNumbers.default(profile))
    times, headings, begin_s, begin_deg = [], [], 0.0, 0.0
    for each in recordings:
        times += (begin_s + each.time_s - each.time_s[0]).tolist()
        headings += (begin_deg + each.heading_deg).tolist()
        begin_s, begin_deg = times[-1], headings[-1]
    return Plot(
        f"autotune of a random chair: {fit.residual_deg:.2f} degrees unexplained",
        "s",
        "heading, degrees",
        [Line("heading sensor", times, headings)],
        band=(-25.0, 25.0),
    )


if __name__ == "__main__":
    main()
