"""Plots the chair for docs/turning-lab.md: both experiments, and B under each reading."""

from __future__ import annotations

from pathlib import Path

from gazesim.chair_axis import Axis
from gazetwin.clues import profile_axis
from gazetwin.experiment import ANGLE_DEG, CUTOFF_DEG, run
from gazetwin.prototype import PUBLISHED, READINGS, Reading
from gazetwin.svg import Line, Mark, Plot, write


def experiments(folder: Path, turn: Axis, reading: Reading) -> Path:
    """Headings over time of A and B on the twin, with the published marks; the file written."""
    a = run(turn, reading, PUBLISHED, 40.0)
    b = run(turn, reading, PUBLISHED, 40.0, CUTOFF_DEG)
    slow = run(profile_axis(turn, "1.2"), reading, PUBLISHED, 40.0, CUTOFF_DEG, "1.2")
    side = 1.0 if a.error_deg(33.0) >= 0.0 else -1.0  # which side was left is not published
    plots = [
        Plot(
            "A: Kp 6, Ki 0.0005, Kd 1, no cut-off",
            "time, s",
            "heading, deg",
            [Line("twin, profile 4.1", a.times_s(), a.headings_deg)],
            [
                Mark(1.2, ANGLE_DEG, "published: first crossing"),
                Mark(33.0, ANGLE_DEG - side * 2.0, "published: 2 deg left"),
            ],
            (ANGLE_DEG - 1.0, ANGLE_DEG + 1.0),
        ),
        Plot(
            "B: the same with the 2 degree cut-off",
            "time, s",
            "heading, deg",
            [
                Line("twin, profile 4.1", b.times_s(), b.headings_deg),
                Line("twin, profile 1.2", slow.times_s(), slow.headings_deg),
            ],
            [
                Mark(25.0, ANGLE_DEG + 1.0, "published: within 10 %"),
                Mark(30.0, ANGLE_DEG - 1.0, "25..30 s"),
            ],
            (ANGLE_DEG - 1.0, ANGLE_DEG + 1.0),
        ),
    ]
    path = folder / "chair-experiments.svg"
    write(path, plots)
    return path


def readings(folder: Path, turn: Axis) -> Path:
    """Experiment B on the twin under every reading of the gains; the file written."""
    lines = []
    for reading in READINGS:
        trace = run(turn, reading, PUBLISHED, 40.0, CUTOFF_DEG)
        lines.append(Line(reading.name, trace.times_s(), trace.headings_deg))
    plot = Plot("B under each reading of the gains", "time, s", "heading, deg", lines)
    plot.band = (ANGLE_DEG - 1.0, ANGLE_DEG + 1.0)
    path = folder / "chair-readings.svg"
    write(path, [plot])
    return path
