"""Which benchmarks `gazechair measure` knows, and one of them run."""

from __future__ import annotations

import importlib
import logging

from gazemeasure.report import Report

# name: (module of this package, what it measures)
BENCHMARKS = {
    "allday": (
        "allday.benchmark",
        "a day of driving: faults, alerts, power cuts, replays",
    ),
    "glance": ("glance", "from the page's event handler to the wipers and back"),
    "go": ("go.benchmark", "auto drives between places in generated homes"),
    "home": (
        "home.benchmark",
        "odometry, maps, localization: a real log, generated homes",
    ),
    "link": ("link", "the serial link: round trip and a bare echo, replugging"),
    "obstacles": (
        "obstacles.benchmark",
        "obstacles and people: our rule, the first prototype's",
    ),
    "page": ("page.benchmark", "the page on a bad network, the host under floods"),
    "person": ("go.person", "following a person: other people, doors, gaits"),
    "plugins": (
        "plugins",
        "inputs and modes: gamepad and mode to the wipers, bad ones, twenty of them, a fuzzer",
    ),
    "scanning": ("scanning", "through a door with one switch, compared with gaze"),
    "tick": ("tick", "the hard tick: allocation, instructions, jitter, telemetry"),
    "turn": (
        "turn.benchmark",
        "turns: ours, the first prototype, a plain PID, the optimum",
    ),
}


def run(name: str, quick: bool) -> Report:
    """Run one benchmark; KeyError when there is none of that name."""
    logging.disable(logging.WARNING)  # log lines of the parts would appear between the figures
    module = importlib.import_module(f"gazemeasure.{BENCHMARKS[name][0]}")
    report: Report = module.measure(quick)
    return report
