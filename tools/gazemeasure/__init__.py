"""Benchmarks behind `gazechair measure NAME`: each measures, prints a table, checks limits."""

from __future__ import annotations

import importlib
import logging

from gazemeasure.report import Report

# name: (module, what it measures)
BENCHMARKS = {
    "allday": ("gazemeasure.allday", "a day of driving: faults, alerts, power cuts, replays"),
    "glance": ("gazemeasure.glance", "from the page's event handler to the wipers and back"),
    "go": ("gazemeasure.go", "auto drives between places in generated homes"),
    "home": ("gazemeasure.home", "odometry, maps, localization: a real log, generated homes"),
    "link": ("gazemeasure.link", "the serial link: round trip and a bare echo, replugging"),
    "obstacles": (
        "gazemeasure.obstacles",
        "obstacles and people: our rule, the first prototype's",
    ),
    "page": ("gazemeasure.page", "the page on a bad network, the host under floods"),
    "person": ("gazemeasure.go_person", "following a person: other people, doors, gaits"),
    "plugins": (
        "gazemeasure.plugins",
        "inputs and modes: gamepad and mode to the wipers, bad ones, twenty of them, a fuzzer",
    ),
    "scanning": ("gazemeasure.scanning", "through a door with one switch, compared with gaze"),
    "tick": ("gazemeasure.tick", "the hard tick: allocation, instructions, jitter, telemetry"),
    "turn": ("gazemeasure.turn", "turns: ours, the first prototype, a plain PID, the optimum"),
}


def run(name: str, quick: bool) -> Report:
    """Run one benchmark; KeyError when there is none of that name."""
    logging.disable(logging.WARNING)  # log lines of the parts would appear between the figures
    module = importlib.import_module(BENCHMARKS[name][0])
    report: Report = module.measure(quick)
    return report
