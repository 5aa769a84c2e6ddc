"""Compares four turn controllers on the same simulated chairs; one is the optimal bound.

The board's own turn controller after the host's own autotune of that chair; the first prototype's
PID; a plain PID with the best gains for the profile; and the time-optimal bound, which knows
chair and disturbances in advance (bound.py). Chairs are gazesim's twin with a heading sensor of
100 Hz. Everything is drawn from seeds: runs are reproducible.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import FloatArray
from gazemeasure.pools import forked
from gazemeasure.report import Report
from gazemeasure.turn import figures
from gazemeasure.turn import jobs as turn_jobs
from gazemeasure.turn import stops as turn_stops
from gazemeasure.turn.bound import bounds
from gazemeasure.turn.cases import Drawn, grid, monte_carlo, published, stepped
from gazemeasure.turn.jobs import DEFAULTS, PLAIN, PROTOTYPE, TUNED, Done, Job
from gazemeasure.turn.judge import DEFINITIONS

_CHAIRS = 1000
_CHAIRS_QUICK = 40
_AT_ONCE = 125  # cases per search of bounds


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    chairs = monte_carlo(_CHAIRS_QUICK if quick else _CHAIRS)
    cases = grid()
    rivals = [d for d in cases if abs(d.case.angle_deg) == 10] if quick else cases
    moments = turn_stops.MOMENTS_MS[:1] if quick else turn_stops.MOMENTS_MS
    report = Report(f"turn: {len(cases)} undisturbed turns, {len(chairs)} random chairs")
    with forked() as pool:
        stops = pool.starmap_async(turn_stops.stop_paths, [(ms, quick) for ms in moments], 1)
        at_best = pool.map_async(_bounds, _parts(cases) + _parts(chairs), 1)
        steps = pool.map_async(turn_jobs.ten_steps, stepped(), 1)
        jobs = [
            *(Job(name, d) for name in (PROTOTYPE, PLAIN) for d in rivals),
            *(Job(TUNED, d) for d in cases + chairs),
            *(Job(DEFAULTS, d) for d in chairs),
            *(Job(name, d) for name in (TUNED, PROTOTYPE) for d in published()),
        ]
        done = pool.map(turn_jobs.run, jobs, chunksize=4)
        done, as_published = done[: -2 * len(published())], done[-2 * len(published()) :]
        best = np.concatenate(at_best.get())
        grid_best, chairs_best = best[: len(cases)], best[len(cases) :]
        tuned = [d for d in done if d.job.controller == TUNED]
        figures.of_grid(report, tuned[: len(cases)], grid_best)
        figures.of_steps(report, steps.get())
        figures.of_chairs(report, tuned[len(cases) :], chairs_best)
        figures.of_defaults(report, _by(done, DEFAULTS))
        figures.of_published(report, _by(as_published, TUNED), _by(as_published, PROTOTYPE))
        figures.of_stops(report, turn_stops.together(stops.get()), done)
        figures.table(report, tuned[: len(cases)], grid_best, _rivals(done))
    for line in DEFINITIONS:
        report.note(line)
    return report


def _parts(cases: list[Drawn]) -> list[list[Drawn]]:
    return [cases[at : at + _AT_ONCE] for at in range(0, len(cases), _AT_ONCE)]


def _bounds(drawn: list[Drawn]) -> FloatArray:
    return bounds([each.case for each in drawn])


def _by(done: list[Done], controller: str) -> list[Done]:
    return [each for each in done if each.job.controller == controller]


def _rivals(done: list[Done]) -> dict[str, list[Done]]:
    return {name: _by(done, name) for name in (PROTOTYPE, PLAIN)}
