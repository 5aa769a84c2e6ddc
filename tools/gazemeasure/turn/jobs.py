"""One turn of one controller on one chair, as a job for a pool of processes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.identify import identify
from gazechair.commissioning.tune.judge import fits_profile
from gazechair.commissioning.tune.judge import judge as judge_fit
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazelink.settings_table import PROFILES
from gazemeasure.turn.board import settings_with
from gazemeasure.turn.cases import Drawn
from gazemeasure.turn.judge import Verdict, judge
from gazemeasure.turn.plain import tuned as tuned_gains
from gazemeasure.turn.rivals import PlainTurn, PrototypeTurn, Rival, turn_of_rival
from gazemeasure.turn.run import steps_of_board, turn_of_board
from gazemeasure.turn.tuning import record, truth
from gazesim.chair import Chair
from gazetwin.prototype import FITTED

_PROTOTYPE_S = 40.0
_PLAIN_S = 15.0
LIMIT_MS = 10_000  # step_turn_limit_ms of every run: a slow chair takes that long for 90 degrees
TUNED, KNOWN, DEFAULTS = "tuned", "known", "defaults"
"""The board's controller: tuned on that chair, knowing it exactly, or with the default settings."""
PROTOTYPE, PLAIN = "prototype", "plain"
"""The first prototype's PID with its published gains; and a plain PID, the best for the profile."""


@dataclass(frozen=True)
class Job:
    """What to run: `controller` is one of the names above."""

    controller: str
    drawn: Drawn


@dataclass(frozen=True)
class Done:
    """The result of a job."""

    job: Job
    verdict: Verdict
    found: TurnNumbers | None = None
    """The result of tuning."""
    refused: str = ""
    """Why tuning refused; the turn then used the default settings."""


@dataclass(frozen=True)
class Steps:
    """Ten steps of 10 degrees after tuning: the total by the sensor, and the true one, degrees."""

    drawn: Drawn
    shown_deg: float
    true_deg: float


def run(job: Job) -> Done:
    """Run one job in this process."""
    drawn = job.drawn
    if job.controller in (PROTOTYPE, PLAIN):
        return _run_rival(job)
    values = {"profile": PROFILES.index(drawn.profile), "step_turn_limit_ms": LIMIT_MS}
    found, refused = None, ""
    if job.controller == KNOWN:
        values |= truth(drawn.case.parameters).rows(drawn.profile)
    elif job.controller == TUNED:
        try:
            found = tune(drawn)
            values |= found.rows(drawn.profile)
        except TuneError as error:
            refused = str(error)
    chair = Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)
    turn = turn_of_board(chair, drawn.imu(), settings_with(values), drawn.case.angle_deg)
    return Done(job, judge(turn), found, refused)


def ten_steps(drawn: Drawn) -> Steps:
    """Tune the chair, then ten steps of the case's angle."""
    values = {"profile": PROFILES.index(drawn.profile), "step_turn_limit_ms": LIMIT_MS}
    values |= tune(drawn).rows(drawn.profile)
    chair = Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)
    settings = settings_with(values)
    return Steps(drawn, *steps_of_board(chair, drawn.imu(), settings, drawn.case.angle_deg, 10))


def _run_rival(job: Job) -> Done:
    drawn = job.drawn
    rival: Rival
    if job.controller == PROTOTYPE:
        rival, seconds = PrototypeTurn(FITTED), _PROTOTYPE_S
    else:
        rival, seconds = PlainTurn(_plain(drawn.profile)), _PLAIN_S
    chair = Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)
    turn = turn_of_rival(chair, drawn.imu(), rival, drawn.case.angle_deg, seconds)
    return Done(job, judge(turn))


_plain = cache(tuned_gains)


def tune(drawn: Drawn) -> TurnNumbers:
    """The result of `gazechair tune` on this chair. Raises TuneError when it refuses."""
    believed = TurnNumbers.default(drawn.profile)
    chair = Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)
    settings = settings_with({"profile": PROFILES.index(drawn.profile)})
    recordings = record(chair, drawn.imu(), settings, drawn.profile, drawn.case.seed)
    fit = identify(recordings, believed)
    judge_fit(recordings, fit)
    fits_profile(fit.numbers, drawn.profile)
    return fit.numbers
