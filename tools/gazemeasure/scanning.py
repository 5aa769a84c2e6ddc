"""Measures a person with one switch who passes a 0.90 m door by scanning, compared with gaze.

The page's own modules (targets.js, switch_scan.js, scan.js) run in Chromium in virtual time; the
whole firmware drives the simulated chair, with one lidar in front. The chair starts 0.4 m beside
the door's axis. The person's part is in scanning_person.py.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from statistics import median
from typing import Any

from playwright.sync_api import Page, sync_playwright

import gazesetup
from gazechair.base.languages import web_folder
from gazechair.people.profiles import fields
from gazedemo.browser import OPTIONS
from gazelink import codes
from gazemeasure.obstacles.firmware import SeeingChair
from gazemeasure.report import Report
from gazemeasure.scanning_person import (
    PRESS_S,
    PRESS_SD_S,
    SCAN_S,
    Gazer,
    Person,
    Switcher,
    Way,
)
from gazesim import chair as twin
from gazesim.random_rooms import door_task
from gazesim.rooms import Room

_DOOR_M, _WALL_M, _BEFORE_M, _BESIDE_M = 0.90, 0.10, 1.6, 0.4
_SEEDS = range(5)
_PROFILE = "3.1"
_TICK_MS = 25
_LIMIT_MS = 300_000
_ORIGIN = "http://page.test/"
_VERBS = {name: codes.VERBS.index(name) for name in ("forward", "left", "right")}
_MODES = {"hold": "continuous", "step": "step"}
_TYPES = {".js": "text/javascript", ".html": "text/html"}
# The page's modules without the page: these names are its targets, and time is ours.
_HTML = '<!DOCTYPE html><body data-link="ok">' + "".join(
    f'<i class="target" id="{name}"></i>'
    for name in ("stop", "forward", "left", "right", "arm", "mode", "help")
)
_BEGIN = """async ([mine, mode]) => {
  const { Targets } = await import("/targets.js");
  const { SwitchScan } = await import("/switch_scan.js");
  let now = 0, moves = false;
  const sent = [];
  performance.now = () => now;
  Object.defineProperty(Event.prototype, "timeStamp", { get: () => now });
  const targets = new Targets({
    drive: (verb, mode, edge) => sent.push([verb, edge]),
    stop: () => sent.push(["stop", 0]),
    act() {}, tap() {}, view() {},
  });
  const hits = { has: (name) => document.getElementById(name) !== null, at: () => null };
  const moving = () => targets.holding || moves;
  const scan = new SwitchScan(targets, hits, { moving, used() {}, needs() {} });
  targets.setTimes(50, 300);
  targets.configure(mine);
  targets.setMode(mode, 0);
  targets.setArmed(true, 0);
  scan.configure(mine, 0);
  window.step = ([at, motion, events]) => {
    [now, moves] = [at, motion];
    for (const [kind, target] of events) {
      if (kind === "look") targets.hover(target, now);
      else document.body.dispatchEvent(new KeyboardEvent(kind, { key: " ", bubbles: true }));
    }
    targets.tick(now);
    scan.tick(now);
    return [sent.splice(0), [...document.querySelectorAll(".lit")].map((lit) => lit.id)];
  };
}"""


@dataclass
class Passage:
    """The result of one run."""

    passed: bool = False
    presses: int = 0
    took_s: float = 0.0
    least_m: float = 1.0
    collisions: int = 0


def measure(quick: bool) -> Report:
    """Both persons, holding and by steps, five seeds; `quick`: holding, one seed. See Report."""
    ways, seeds = (["hold"], _SEEDS[:1]) if quick else (list(_MODES), _SEEDS)
    report = Report(f"scanning: a {_DOOR_M:.2f} m door with one switch and by gaze")
    os.nice(15)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(gazesetup.ensure_chromium()), args=list(OPTIONS)
        )
        for way in ways:
            for name, kind in (("one switch", Switcher), ("gaze", Gazer)):
                found = []
                for seed in seeds:
                    page = browser.new_page()
                    found.append(_Run(page, kind(seed, way == "hold"), way, seed)())
                    page.close()
                _add(report, f"{name}, {way}", found)
        browser.close()
    report.note("presses: closings of the switch, or dwells that began a motion. seconds: from the")
    report.note("first light or look until the whole chair is behind the wall. One switch: rows,")
    pressed = f"{PRESS_S:.2f} s (sd {PRESS_SD_S:.2f} s)"
    report.note(f"scan time {SCAN_S:g} s, the person presses {pressed} after the light; gaze:")
    dwell_s = _defaults()["dwell_ms"] / 1000
    report.note(f"dwell {dwell_s:g} s. Chair: speed profile {_PROFILE}, the board's own settings.")
    return report


def _add(report: Report, name: str, found: list[Passage]) -> None:
    report.add(f"{name}: passed", sum(one.passed for one in found), "", len(found), at_least=True)
    report.add("  collisions", sum(one.collisions for one in found), "", 0)
    for what, unit, values in (
        ("presses", "", [one.presses for one in found]),
        ("seconds", "s", [one.took_s for one in found]),
    ):
        report.add(f"  {what}, median", median(values), unit)
        report.add(f"  {what}, worst", max(values), unit)
    report.add("  smallest distance to the door", min(one.least_m for one in found), "m")


class _Run:
    """One person, one door: page, chair and person step by step."""

    def __init__(self, page: Page, person: Person, way: str, seed: int) -> None:
        self._page = page
        self._person = person
        self._edge = 0
        self._sent_ms = 0
        side = 1 if seed % 2 else -1
        room = door_task(_DOOR_M, _WALL_M, 0.0, 0.0, _BEFORE_M).room
        start = (room.start[0], side * _BESIDE_M, 0.0)
        self._room = Room("door", room.walls, room.furniture, start=start)
        self._chair = SeeingChair(self._room, _PROFILE)
        self._way = Way(_WALL_M, 6.0 if way == "step" else 2.5)  # a step turns 10 degrees
        self._mode = codes.MODES.index(_MODES[way])
        page.route(f"{_ORIGIN}**", lambda route: route.fulfill(**_file(route.request.url)))
        page.goto(_ORIGIN)
        scan = "rows" if isinstance(person, Switcher) else "off"
        mine = _defaults() | {"scan": scan, "scan_ms": round(1000 * SCAN_S)}
        page.evaluate(_BEGIN, [mine, _MODES[way]])

    def __call__(self) -> Passage:
        """Run it to the end."""
        chair, outcome = self._chair, Passage()
        chair.arm()
        chair.run(300)
        begun_ms = chair.now_ms
        while chair.now_ms < begun_ms + _LIMIT_MS:
            state = chair.link.state()
            moves = state is not None and state.motion_name != "stopped"
            self._way.see(chair.world.chair)
            events = self._person.tick((chair.now_ms - begun_ms) / 1000, self._way, moves)
            sent, lit = self._page.evaluate(
                "input => step(input)", [chair.now_ms - begun_ms, moves, events]
            )
            for what, edge in sent:
                self._obey(what, edge, (chair.now_ms - begun_ms) / 1000)
            self._person.sees(lit)
            chair.holds = chair.now_ms - self._sent_ms < 2 * _TICK_MS + 1
            chair.run(_TICK_MS)
            pose = chair.world.chair
            gap_m = self._room.clearance_m(pose.x_m, pose.y_m, pose.heading_deg)
            outcome.least_m = min(outcome.least_m, gap_m)
            outcome.collisions = chair.world.collisions
            if pose.x_m + twin.REAR_M > _WALL_M or outcome.collisions:
                outcome.passed = not outcome.collisions
                break
        outcome.presses = self._person.presses
        outcome.took_s = (chair.now_ms - begun_ms) / 1000
        return outcome

    def _obey(self, what: str, edge: int, now_s: float) -> None:
        if what == "stop":
            self._chair.release()
        elif edge > self._edge:
            self._edge = edge
            self._chair.press(_VERBS[what], self._mode)
        self._person.receives(what, edge, now_s, self._way)
        self._sent_ms = self._chair.now_ms


def _defaults() -> dict[str, Any]:
    """A new person's profile."""
    return {name: field.default for name, field in fields(["en"], {}).items()}


def _file(url: str) -> dict[str, str]:
    name = url.removeprefix(_ORIGIN)
    if not name:
        return {"body": _HTML, "content_type": _TYPES[".html"]}
    return {"body": (web_folder() / name).read_text("utf-8"), "content_type": _TYPES[".js"]}
