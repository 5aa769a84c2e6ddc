"""Replays recorded drives through the safety core: equal decisions, and changed limits found."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from unittest import mock

from gazeboard.core import limits
from gazemeasure.allday.chair import DayChair
from gazemeasure.report import Report
from gazereplay.replay import replay


def tour(chair: DayChair) -> None:
    """Forward, a step to the left, then towards a standing object."""
    chair.arm()
    chair.moves_after(k="cmd", verb="forward", mode="continuous")
    chair.run(1500)
    chair.driver.release()
    chair.run(1000)
    chair.moves_after(k="cmd", verb="left", mode="step")
    chair.run(2500)
    chair.driver.release()
    chair.run(300)
    chair.world.faults.inject("obstacle", ahead_m=1.6, left_m=0.0, size_m=0.2)
    chair.moves_after(k="cmd", verb="forward", mode="continuous")
    chair.until(lambda: chair.override() == "obstacle_forward", 6000)
    chair.run(300)


def cable(chair: DayChair) -> None:
    """Pull the plug for a while, and kill the host."""
    chair.arm()
    chair.moves_after(k="cmd", verb="forward", mode="continuous")
    chair.run(300)
    chair.cable.pull()
    chair.run(700)
    chair.cable.plug()
    chair.driver.release()
    chair.arm()
    chair.moves_after(k="cmd", verb="right", mode="continuous")
    chair.run(500)


def failing(chair: DayChair) -> None:
    """Heading, potentiometer, service loop, tick, then the board itself fail."""
    chair.arm()
    chair.moves_after(k="cmd", verb="left", mode="continuous")
    chair.run(300)
    for fault in ("imu_freeze", "wiper_nak"):
        chair.world.faults.inject(fault)
        chair.run(200)
        chair.world.faults.clear(fault)
        chair.run(300)
    chair.caretaker.say(k="reset")
    chair.driver.release()
    chair.arm()
    chair.moves_after(k="cmd", verb="forward", mode="continuous")
    chair.board.blocked = True
    chair.run(80)
    chair.board.blocked = False
    chair.run(300)
    chair.board.hung = True
    chair.run(30)
    chair.board.hung = False
    chair.run(500)
    chair.board.reset()
    chair.run(2000)


DRIVES: tuple[Callable[[DayChair], None], ...] = (tour, cable, failing)
# A limit, another value of it, and the drive in which it decides.
_CHANGED = (
    ("NEUTRAL_PROVEN_MS", 499, 0),
    ("CREEP_MOST_MM_S", 160, 0),
    ("HOST_SILENT_MS", 99, 1),
    ("SERVICE_STALLED_MS", 49, 2),
)


def add(report: Report) -> None:
    """Replay three drives, and four changed limits."""
    equal, ticks, found = 0, 0, 0
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        files = []
        for number, drive in enumerate(DRIVES):
            chair = DayChair(Path(name) / str(number), record=True)
            drive(chair)
            files.append(chair.close())
            result = replay(files[-1])
            equal += result.difference is None
            ticks += result.ticks
            if result.difference is not None:
                report.note(f"{drive.__name__}: {result.difference}")
        for limit, value, number in _CHANGED:
            with mock.patch.object(limits, limit, value):
                found += replay(files[number]).difference is not None
    report.add("replay: ticks", ticks, "")
    share = 100 * equal / len(DRIVES)
    report.add("  drives with every decision the same", share, "%", 100, at_least=True)
    report.add(
        f"  of {len(_CHANGED)} changed limits found", found, "", len(_CHANGED), at_least=True
    )
