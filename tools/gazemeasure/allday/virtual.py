"""A day of driving in virtual time: the whole firmware and the host's parts, faults included."""

from __future__ import annotations

import gc
import os
import random
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from gazechair.alerts.book import AGAIN_S, MOST_ALERTS, Book
from gazechair.alerts.diary import Diary
from gazechair.alerts.reasons import HELP_WANTED
from gazemeasure.allday import record
from gazemeasure.allday.chair import DayChair
from gazemeasure.allday.faults import BACK_S
from gazemeasure.growth import Holding, slope_per_hour
from gazemeasure.report import Report, percentile

DAY_S = 86400.0
_LOOK_S = 60.0
_HELD_S = (0.3, 3.0)
_RESTS_S = (0.2, 2.0)
_PAST_START = 0.2  # share of the time: then caches are full
_WAYS = ("forward", "left", "right")
_FAULT_EACH = 12  # presses
_SEED = 14


@dataclass
class Day:
    """The results of a day."""

    presses: int = 0
    overruled: int = 0
    faults: dict[str, int] = field(default_factory=dict)
    stuck: list[str] = field(default_factory=list)
    """Faults after which the driver's own arm and press did not move the chair in time."""
    back_s: list[float] = field(default_factory=list)
    to_wipers_ms: list[tuple[float, float]] = field(default_factory=list)
    objects: list[tuple[float, float]] = field(default_factory=list)
    holding: Holding = field(default_factory=Holding)
    state_bytes: int = 0
    lived_s: float = 0.0
    took_s: float = 0.0


class _Living:
    """Drives, rests, and injects faults now and then; random events come from a seed."""

    def __init__(self, chair: DayChair, life: Life) -> None:
        self._chair = chair
        self._fault_each = life.fault_each
        self._dice = random.Random(life.seed)
        self.day = Day()
        self._faults: dict[str, Callable[[], None]] = {
            "host killed": self._host_killed,
            "cable pulled": self._cable,
            "board reset": self._board_reset,
            "board hangs": self._board_hangs,
            "lidar silent": lambda: self._for_a_while("lidar_stall"),
            "heading frozen": lambda: self._for_a_while("imu_freeze"),
            "heading reset": lambda: self._for_a_while("imu_self_reset"),
            "potentiometer silent": self._potentiometer,
            "emergency stop": self._emergency,
            "help": self._help,
            "caretaker drives": self._caretaker,
            "speed cap": self._cap,
            "profile": self._profile,
        }

    def live(self, until: Callable[[], bool]) -> Day:
        """Live until `until` is true."""
        look_ms = 0
        while not until():
            self._press()
            if self.day.presses % self._fault_each == 0:
                self._fail()
            if self._chair.now_ms >= look_ms:
                look_ms = self._chair.now_ms + round(1000 * _LOOK_S)
                self._look()
        return self.day

    def _look(self) -> None:
        gc.collect()
        now_s = self._chair.now_s()
        self.day.objects.append((now_s, len(gc.get_objects())))
        self.day.holding.look(os.getpid(), now_s)

    def _press(self) -> None:
        chair, day = self._chair, self.day
        if not chair.armed():
            chair.arm()
        button: dict[str, Any] = {"k": "cmd", "verb": self._dice.choice(_WAYS)}
        button["mode"] = self._dice.choice(("continuous", "step"))
        day.presses += 1
        took_ms = chair.moves_after(**button)
        if took_ms is None:
            day.overruled += 1
        else:
            day.to_wipers_ms.append((chair.now_s(), took_ms))
        self._pass(*_HELD_S)
        chair.driver.release()
        self._pass(*_RESTS_S)
        if took_ms is None or self._dice.random() < 0.1:
            self._begin_again()

    def _begin_again(self) -> None:
        chair = self._chair
        chair.until(chair.stands, 4000)
        chair.world.teleport(*chair.world.room.start)
        chair.run(300)

    def _pass(self, least_s: float, most_s: float) -> None:
        self._chair.run(round(1000 * self._dice.uniform(least_s, most_s)))

    def _fail(self) -> None:
        """Inject a fault while the chair drives; then it must drive again."""
        chair, day = self._chair, self.day
        name = self._dice.choice(list(self._faults))
        day.faults[name] = day.faults.get(name, 0) + 1
        self._begin_again()
        chair.driver.press(k="cmd", verb="forward", mode="continuous")
        chair.run(400)
        self._faults[name]()
        begun_ms = chair.now_ms
        chair.driver.release()
        try:
            chair.until(chair.stands, 4000)
            chair.world.teleport(*chair.world.room.start)
            chair.arm()
            while chair.moves_after(k="cmd", verb="left", mode="continuous") is None:
                chair.driver.release()
                chair.run(100)
                if chair.now_ms - begun_ms > 1000 * BACK_S:
                    raise AssertionError(chair.why())
            day.back_s.append((chair.now_ms - begun_ms) / 1000)
        except AssertionError as error:
            day.stuck.append(f"{name}: {error}")
            chair.board.reset()  # what a person would do
            chair.run(2000)
        chair.driver.release()
        chair.run(200)

    # -- faults, and actions of people --

    def _for_a_while(self, fault: str) -> None:
        chair = self._chair
        chair.world.faults.inject(fault)
        self._pass(0.5, 2.0)
        chair.world.faults.clear(fault)

    def _potentiometer(self) -> None:
        self._for_a_while("wiper_nak")
        self._chair.caretaker.say(k="reset")  # it latches: a person must clear it

    def _host_killed(self) -> None:
        self._chair.kill_host()
        self._pass(1.0, 2.0)
        self._chair.start_host()

    def _cable(self) -> None:
        self._chair.cable.pull()
        self._pass(0.5, 2.0)
        self._chair.cable.plug()

    def _board_reset(self) -> None:
        self._chair.board.reset()

    def _board_hangs(self) -> None:
        self._chair.board.hung = True
        self._pass(0.005, 0.4)
        self._chair.board.hung = False

    def _emergency(self) -> None:
        self._chair.driver.say(k="emergency")
        self._pass(0.5, 2.0)
        self._chair.caretaker.say(k="reset")

    def _help(self) -> None:
        chair = self._chair
        assert chair.host is not None
        chair.driver.say(k="call", on=True)
        self._pass(0.5, 2.0)
        newest = chair.host.alerts.as_json()["alerts"][-1]
        chair.host.alerts.acknowledge(newest["number"], "Anna")
        self._pass(0.5, 1.0)
        chair.caretaker.say(k="call", on=False, there=True)

    def _caretaker(self) -> None:
        chair = self._chair
        chair.caretaker.say(k="take")
        self._pass(0.3, 0.5)
        chair.caretaker.press(k="drive", linear=300, turn=self._dice.choice((-300, 0, 300)))
        self._pass(0.5, 2.0)
        chair.caretaker.release()
        chair.caretaker.say(k="release")

    def _cap(self) -> None:
        self._chair.caretaker.say(k="cap", permille=self._dice.choice((500, 700, 1000)))
        self._pass(0.1, 0.5)

    def _profile(self) -> None:
        chair = self._chair
        assert chair.host is not None
        dwell_ms = self._dice.choice((400, 600, 800))
        chair.host.control.change_profile({"save": {"id": "1", "dwell_ms": dwell_ms}}, "driver")
        self._pass(0.1, 0.5)


@dataclass(frozen=True)
class Life:
    """One life of firmware and host: `wanted_s` of virtual time; `seed` gives random events."""

    wanted_s: float
    seed: int
    fault_each: int
    """Presses from one fault to the next."""


def live(life: Life) -> Day:
    """Live it; in its own process, whose resources are part of the result."""
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        _fill_diary(Path(name))
        chair = DayChair(Path(name))
        chair.run(1500)
        began_s = time.monotonic()
        day = _Living(chair, life).live(lambda: chair.now_s() >= life.wanted_s)
        day.took_s = time.monotonic() - began_s
        day.lived_s = chair.now_s()
        day.state_bytes = sum(file.stat().st_size for file in Path(name).iterdir())
    return day


def add(report: Report, wanted_s: float) -> None:
    """Live `wanted_s` of virtual time: one life per core, in parallel."""
    cores = len(os.sched_getaffinity(0))
    lives = [Life(wanted_s / cores, _SEED + core, _FAULT_EACH) for core in range(cores)]
    day = Report("allday: a day in virtual time")
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn")) as pool:
        add_rows(day, list(pool.map(live, lives)), wanted_s)
    if wanted_s >= DAY_S:
        record.write(day)
    report.figures += day.figures
    report.notes += [*day.notes, record.sentence()]


def _fill_diary(folder: Path) -> None:
    """Fill the diary as after months, so that it no longer grows."""
    book = Book([])
    for number in range(MOST_ALERTS):
        book.raise_(HELP_WANTED, number * AGAIN_S, 1e9)
        book.end(HELP_WANTED, (number - 1) * AGAIN_S)
    Diary(folder).write(book.as_json())


def add_rows(report: Report, days: list[Day], wanted_s: float) -> None:
    """Add the results of all lives together."""
    long = min(day.lived_s for day in days) >= 3600.0

    def all_of(name: str) -> list[Any]:
        return [value for day in days for value in getattr(day, name)]

    def slope(points: Callable[[Day], list[tuple[float, float]]]) -> float:
        """The worst of all lives, without their start."""
        return max(
            slope_per_hour([at for at in points(day) if at[0] >= day.lived_s * _PAST_START])
            for day in days
        )

    lived_s = sum(day.lived_s for day in days)
    report.add("virtual day: hours driven", lived_s / 3600, "h", wanted_s / 3600, at_least=True)
    report.add("  in lives", len(days), "")
    speed = sum(day.lived_s / day.took_s for day in days)
    report.add("  times as fast as the clock, all lives", speed, "")
    presses = sum(day.presses for day in days)
    report.add("  presses", presses, "")
    overruled = sum(day.overruled for day in days)
    report.add("  overruled (something is in the way)", overruled, "", 0.1 * presses)
    report.add("  faults while driving", sum(sum(day.faults.values()) for day in days), "")
    stuck = all_of("stuck")
    report.add("  not driving again by arm and press", len(stuck), "", 0)
    report.add("  driving again, p95", percentile(all_of("back_s"), 0.95), "s", BACK_S)
    times = [ms for _, ms in all_of("to_wipers_ms")]
    report.add("  press -> wipers, p99", percentile(times, 0.99), "ms", 60.0)
    for name, points, unit, limit in (
        ("press -> wipers", lambda day: day.to_wipers_ms, "ms/h", 0.1),
        ("memory", lambda day: day.holding.memory_mb, "MB/h", 0.5),
        ("objects", lambda day: day.objects, "1/h", 50.0),
        ("open files", lambda day: day.holding.files, "1/h", 0.0),
    ):
        report.add(f"  {name}, slope (worst life)", slope(points), unit, limit if long else None)
    most = max(day.state_bytes for day in days)
    report.add("  state folder at the end", most / 1000, "kB", 200.0)
    for line in stuck[:5]:
        report.note(f"virtual day: {line}")
