"""Measures whether the chair runs all day: faults, power cuts, alerts, replays.

A day in virtual time; then the demo's processes, a random part of which is killed, stopped or
starved each 20 s; `kill -9` under a real page; alerts over two routes; power cuts; recorded drives.
"""

from __future__ import annotations

import contextlib
import os

import gazesetup
from gazemeasure.allday import alerts, kill, power, real, replay, virtual
from gazemeasure.report import Report
from gazemeasure.stalls import STALL_S

_NICE = -5  # the unit file's; the simulated devices need no processor in a chair
_REAL_S = 1800.0
_QUICK_VIRTUAL_S, _QUICK_REAL_S = 180.0, 160.0
_CUTS, _QUICK_CUTS = 1000, 50


def measure(quick: bool) -> Report:
    """See the module. `quick` takes some six minutes, else three hours."""
    report = Report("allday: a day of driving, and everything that can fail in it")
    # As installed: a part that starts again finds its code compiled.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    micropython = str(gazesetup.ensure_micropython().path)
    replay.add(report)
    power.add(report, _QUICK_CUTS if quick else _CUTS)
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, _NICE)
    alerts.add(report, micropython, 1 if quick else 5, 10.0 if quick else 60.0)
    kill.add(report, micropython, 2 if quick else 10)
    real.add(report, micropython, _QUICK_REAL_S if quick else _REAL_S)
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, 0)
    virtual_s = _QUICK_VIRTUAL_S if quick else virtual.DAY_S
    virtual.add(report, virtual_s)
    load = os.getloadavg()[0]
    report.note("Well again: less the time in which the part's new process (of a daemon's and its")
    report.note("lidars', the one that waited longer) could run and others had the processors.")
    report.note(f"Times that overlap a stall of the machine of over {1000 * STALL_S:g} ms are")
    report.note(f"dropped where they would fall short; load of the machine at the end: {load:.1f}.")
    report.note("The Debian package: tests/tools/test_deb.py installs, upgrades and rolls it back.")
    return report
