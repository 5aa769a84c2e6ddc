"""Measures how well the chair knows where it is and how fast it moves, without wheel encoders.

Real: public logs (../shared/data, or GAZECHAIR_DATA), with headings as the board's sensor would
give them: scale 0.5 %, drift 0.3 degrees a minute, noise 0.1 degree.
Simulated: drives through generated homes with doors, people, glass and mirrors.
"""

from __future__ import annotations

import time
from functools import partial

import numpy as np

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.lidar.dense import CapsuleDecoder
from gazechair.sensing.mapping.building.pose_graph import MissingPackageError
from gazechair.sensing.odometry.odometry import Odometry
from gazemeasure.home import (
    alarms,
    drives,
    faults,
    foreign,
    forward,
    localization,
    logs,
    record,
    upkeep,
)
from gazemeasure.home import odometry as home_odometry
from gazemeasure.home import process as home_process
from gazemeasure.pools import forked
from gazemeasure.report import Report, percentile
from gazesim import home_plans
from gazesim.home_drive import FRONT, Drive
from gazesim.s2_frames import capsules

_DENSE = 3200  # points a turn
_PARTS = (
    (drives, record.DRIVES),
    (localization, record.STARTS),
    (foreign, record.FOREIGN),
    (faults, record.FAULTS),
    (upkeep, record.UPKEEP),
    (alarms, record.ALARMS),
    (forward, record.FORWARD),
)


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    report = Report("home: knows where it is")
    try:
        logs.measure(report, quick)
    except MissingPackageError as error:
        report.note(f"maps of public logs not measured: {error}")
    with forked() as pool:
        each = partial(pool.map, chunksize=1)
        home_odometry.measure(report, quick, each)
        for part, stored in _PARTS:
            part.measure(report, quick, each if quick else stored.each)
    _cost(report, 5.0 if quick else 30.0)
    home_process.measure(report, quick, _DENSE)
    return report


def _cost(report: Report, seconds: float) -> None:
    """Add the cost from the bytes of a dense turn to the pose: decoding and both pieces."""
    driven = Drive(home_plans.home(2), 2, (FRONT,), per_turn=_DENSE)
    odometry, decoder = Odometry(), CapsuleDecoder()
    turns, spent_ms = 0, []
    for event in driven.events(seconds):
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        share = np.arange(_DENSE // 2) / _DENSE
        metres = np.resize(event.distances_m, _DENSE // 2)
        octets = capsules(share, 1000.0 * metres, after_reset=turns == 0).tobytes()
        begin_s = time.process_time()
        decoder.feed(octets)
        odometry.piece(event)
        spent_ms.append(1000.0 * (time.process_time() - begin_s))
        turns += 1
    whole = [a + b for a, b in zip(spent_ms[::2], spent_ms[1::2], strict=False)]
    report.add(
        f"a turn of {_DENSE} points, bytes to pose, median", percentile(whole, 0.5), "ms", 10.0
    )
    report.add("  95 %", percentile(whole, 0.95), "ms")
