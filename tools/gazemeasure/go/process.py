"""A ride to the kitchen in real processes: how much of a core the host and all its parts take."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import gazesetup
from gazedemo import home, home_check
from gazedemo.check import CheckFailed
from gazedemo.stack import Stack
from gazemeasure.growth import cpu_s, family
from gazemeasure.report import Report

_SHARE = 60.0


def measure(report: Report) -> None:
    """Add the rows; where there is no Chromium, or the ride fails, a note with the reason."""
    try:
        chromium = gazesetup.ensure_chromium()
        micropython = str(gazesetup.ensure_micropython().path)
    except gazesetup.NotAvailable as error:
        report.note(f"a ride in real processes not measured: {error}")
        return
    with (
        tempfile.TemporaryDirectory(prefix="gazechair-") as name,
        Stack(micropython, home.ROOM, lidars=home.LIDARS, prepare=home.prepare) as stack,
    ):
        before_s, begun_s = _taken_s(stack), time.monotonic()
        try:
            figures = home_check.check(stack, chromium, Path(name))
        except CheckFailed as error:
            report.add("a ride in real processes: arrived", 0, "", 1, at_least=True)
            report.note(f"the ride in real processes: {error}")
            return
        share = 100.0 * (_taken_s(stack) - before_s) / (time.monotonic() - begun_s)
    report.add("a ride in real processes: arrived", 1, "", 1, at_least=True)
    report.add("  the host and all its parts: share of a core", share, "%", _SHARE)
    report.add("  pressed again", figures["pressed_again"], "times")


def _taken_s(stack: Stack) -> float:
    return sum(cpu_s(pid) for pid in family(stack.pid("host")))
