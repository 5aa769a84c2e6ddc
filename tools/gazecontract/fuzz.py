"""Fuzzes what may send commands: pages, inputs and modes, anything, in any order, at any time.

`python -m gazecontract.fuzz [--messages N] [--seed N]`: through the daemon's Control, with a link
that only records, in virtual time. A command that nothing permits ends it and prints the seed.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
from dataclasses import replace
from typing import Any
from unittest import mock

from gazechair.base.health import OK, HealthRegistry
from gazechair.config.settings import Config
from gazechair.driving.clients import ROLES
from gazechair.driving.control import Control
from gazechair.plugins import NOTHING, STOP, choose, drive, hold, step
from gazechair.plugins.exchange import BadValue, Value
from gazechair.plugins.value_checks import InputRun, ModeRun
from gazecontract.fuzz_senders import Device, Link, Page, meaning_of, motion_of
from gazecontract.sender_oracle import Oracle, PressKey, Violation
from gazelink import codes

_MODES = ("ahead", "round")
_VERBS = ("forward", "backward", "left", "right")
_MODE_NAMES = ("step", "continuous")
_INPUT_RESTS_S = 0.3
_CHOICES = ("arm",) * 12 + ("take", "disarm", "emergency", "release")
_RUN = 20_000  # messages of a run


class Fuzz:
    """One run; `messages` counts those sent."""

    def __init__(self, seed: int) -> None:
        self._chance = random.Random(seed)
        self._now_s = 100.0
        self._link = Link()
        parts = HealthRegistry(self._clock)
        for name in ("board", "lidar", "camera"):
            parts.part(name).set(OK)
        with mock.patch("secrets.randbelow", self._chance.randrange):
            self._control = Control(Config(), self._link, parts, clock=self._clock)
        self._control.update()
        self.oracle = Oracle()
        self.messages = 0
        self._session = 1
        self._stopped_s = 0.0
        self._pages = [
            Page(role, self._control.connect(role), f"page {n}")
            for n, role in enumerate(("driver", "driver", "caretaker", "viewer"))
        ]
        self._inputs = [
            Device(role, f"input {role}", InputRun(self._control, role, self._clock))
            for role in ("driver", "caretaker")
        ]
        self._modes = {name: self._new_mode(name) for name in _MODES}
        self._owner: Page | None = None
        self._acts = [
            (30, self._page_speaks),
            (30, self._input_speaks),
            (20, self._mode_speaks),
            (4, self._page_presses),
            (2, self._input_changes),
            (1, self._page_releases),
            (2, self._page_chooses),
            (1, self._plugin_misbehaves),
            (1, self._plugin_restarts),
            (0.4, self._board_changes),
            (0.2, self._page_reconnects),
        ]

    def _clock(self) -> float:
        return self._now_s

    def run(self, messages: int) -> None:
        """Send this many. Raises Violation."""
        weights = [weight for weight, _ in self._acts]
        while self.messages < messages:
            self._pass(self._chance.choice((0.0, 0.0, 0.001, 0.005, 0.02, 0.06, 0.2)))
            if self._chance.random() < 0.04:
                self._somebody_rests()
            for _, act in self._chance.choices(self._acts, weights, k=4):
                act()
                self._follow_orders()
                self._judge()

    def _pass(self, seconds: float) -> None:
        # The daemon ticks 40 times a second; everybody alive keeps sending heartbeats.
        while seconds > 0.0:
            self._now_s += min(seconds, 0.02)
            seconds -= 0.02
            for page in self._pages:
                if self._chance.random() < 0.3:
                    self._beat(page)
            if self._chance.random() < 0.6:
                self._speak_all()
            self._control.update()
            self._judge()

    def _speak_all(self) -> None:
        for page in self._pages:
            self._repeat(page)
        for one in self._inputs:
            self._value(one)
        self._mode_speaks()

    def _judge(self) -> None:
        self.oracle.judge(self._link.sent, self._now_s)

    # -- pages --

    def _say(self, page: Page, late_s: float = 0.0, **message: Any) -> bool:
        """Send it; True if it was accepted."""
        self.messages += 1
        token = self._control.proof(self._now_s - late_s)
        return self._control.receive(page.client, {**message, "token": token}) == []

    def _beat(self, page: Page) -> None:
        self.oracle.page_lives(ROLES[page.role], self._now_s)
        self._say(page, k="hb")

    def _page_speaks(self) -> None:
        page = self._chance.choice(self._pages)
        self._beat(page)
        self._repeat(page, self._chance.choice((0.0, 0.0, 0.0, 0.1, 0.2, 0.26, 1.0)))

    def _repeat(self, page: Page, late_s: float = 0.0) -> None:
        if page.held is None:
            return
        birth_s = self._now_s - late_s
        if page.role != "viewer" and Oracle.fresh(birth_s, self._now_s):
            kind = page.held["k"]
            motion = None if kind == "mode" else motion_of(page.held)
            key = (page.name, page.life, page.edge)
            role = ROLES[page.role]
            if page is not self._owner:
                self.oracle.never(key)
            self.oracle.page_lives(role, self._now_s)
            mode = page.held["mode"] if kind == "mode" else ""
            self.oracle.wants(key, role, motion, mode, birth_s)
        self._say(page, late_s, edge=page.edge, **page.held)

    def _page_presses(self) -> None:
        page = self._chance.choice(self._pages)
        if page is not self._owner and self._chance.random() < 0.8:
            page = self._owner or page
        page.edge += 1
        c = self._chance
        page.held = c.choice(
            (
                {"k": "cmd", "verb": c.choice(_VERBS), "mode": c.choice(_MODE_NAMES)},
                {"k": "drive", "linear": c.randint(-1000, 1000), "turn": c.randint(-9, 9)},
                {"k": "mode", "mode": c.choice(_MODES)},
            )
        )
        self._repeat(page)

    def _page_releases(self) -> None:
        page = self._chance.choice(self._pages)
        if page.held is None and self._chance.random() < 0.7:
            return
        page.held = None
        if page.role != "viewer":
            self.oracle.stops()
            self._stopped_s = self._now_s
        self._say(page, k="stop")

    def _page_chooses(self) -> None:
        page = self._chance.choice(self._pages)
        what = self._chance.choice(_CHOICES)
        if what == "arm" and self.oracle.armed and self._chance.random() < 0.9:
            return
        if not self._say(page, k=what) or page.role == "viewer":
            return
        if what == "release" and page is not self._owner:
            return
        self.oracle.stops()
        if what in ("disarm", "emergency"):
            self._stopped_s = self._now_s
        self._own(page if what in ("arm", "take") else None)

    def _page_reconnects(self) -> None:
        page = self._chance.choice(self._pages)
        self.oracle.ends_of(page.name)
        if page is self._owner:
            self.oracle.stops()
            self._own(None)
        self._control.disconnect(page.client)
        page.client = self._control.connect(page.role)
        page.life, page.edge, page.held = page.life + 1, 0, None

    def _own(self, page: Page | None) -> None:
        self._owner = page
        self.oracle.owner = codes.NOBODY if page is None else ROLES[page.role]

    # -- plug-ins --

    def _input_changes(self, which: Device | None = None) -> None:
        one = which or self._chance.choice(self._inputs)
        c = self._chance
        intent = c.choice(
            (
                *(NOTHING,) * (6 if one.intent.moves else 1),
                STOP if c.random() < 0.2 else NOTHING,
                hold(c.choice(_VERBS)),
                step(c.choice(_VERBS)),
                drive(c.randint(-1000, 1000), c.randint(-1000, 1000)),
                choose(c.choice((*_MODES, "none such"))),
            )
        )
        one.press += intent.moves and (intent.do, intent.what) != (one.intent.do, one.intent.what)
        one.stops += intent == STOP != one.intent
        one.intent = intent
        self._value(one)

    def _somebody_rests(self) -> None:
        one = self._chance.choice(self._inputs)
        one.intent = NOTHING
        self._pass(self._chance.choice((0.28, 0.36)))
        self._input_changes(one)

    def _input_speaks(self) -> None:
        late_s = self._chance.choice((0.0, 0.0, 0.0, 0.01, 0.2, 0.26))
        self._value(self._chance.choice(self._inputs), late_s)

    def _value(self, one: Device, late_s: float = 0.0) -> None:
        birth_s = self._now_s - late_s
        counts = Oracle.fresh(birth_s, self._now_s) and birth_s >= one.born_s
        if counts and late_s < 0.249:
            one.born_s = max(one.born_s, birth_s)
            self._tell(one, birth_s)
        self.messages += 1
        try:
            one.life.take(Value(birth_s, one.press, one.intent, one.stops).pack())
        except BadValue:
            self._restart(one)  # it sent only old values for a second

    def _tell(self, one: Device, birth_s: float) -> None:
        intent = one.intent
        role = ROLES[one.role]
        key: PressKey = (one.name, one.lives, one.press)
        if intent == STOP:
            self.oracle.stops()
            self._stopped_s = self._now_s
        elif intent == NOTHING:
            self._rest(one, birth_s)
            self.oracle.lets_go(one.name)
            return
        else:
            if one.rested_s <= max(one.began_s, self._stopped_s):
                self.oracle.never(key)
            mode = intent.what if intent.do == "choose" else ""
            self.oracle.wants(key, role, None if mode else meaning_of(intent), mode, birth_s)
        one.nothing_s = None

    def _rest(self, one: Device, birth_s: float) -> None:
        one.nothing_s = birth_s if one.nothing_s is None else one.nothing_s
        if birth_s - max(one.nothing_s, one.began_s, self._stopped_s) >= _INPUT_RESTS_S:
            one.rested_s = birth_s

    def _restart(self, one: Device) -> None:
        self.oracle.ends_of(one.name)
        one.life.end()
        one.life = InputRun(self._control, one.role, self._clock)
        one.lives += 1
        one.rested_s, one.born_s, one.nothing_s = 0.0, 0.0, None
        one.began_s = self._now_s
        if self._chance.random() < 0.5:
            one.press, one.stops = 0, 0

    def _new_mode(self, name: str) -> ModeRun:
        self._control.offer_mode(name, {"icon": "", "names": {}})
        return ModeRun(self._control, name, self._clock)

    def _restart_mode(self, name: str) -> None:
        self.oracle.mode_ends(name)
        self._control.offer_mode(name, None)
        self._judge()
        self._modes[name] = self._new_mode(name)

    def _mode_speaks(self) -> None:
        c = self._chance
        context = self._control.mode_context()
        name = context.mode if context.mode in _MODES and c.random() < 0.9 else c.choice(_MODES)
        number = context.press if c.random() < 0.9 else c.randint(0, 1 + context.press)
        late_s = c.choice((0.0, 0.0, 0.02, 0.24, 0.26))
        intent = NOTHING if c.random() < 0.02 else drive(c.randint(-1000, 1000), c.randint(-50, 50))
        birth_s = self._now_s - late_s
        if intent == NOTHING:
            birth_s = self._now_s
            if (context.mode, context.press) == (name, number):
                self.oracle.mode_ends(name)
        elif (context.mode, context.press) == (name, number):
            out = (intent.linear_permille, intent.turn_permille)
            self.oracle.steers(name, number, out, birth_s)
        self.messages += 1
        try:
            self._modes[name].take(Value(birth_s, number, intent).pack())
        except BadValue:
            self._restart_mode(name)

    def _plugin_misbehaves(self) -> None:
        c = self._chance
        self.messages += 1
        good = Value(self._now_s, 1, drive(1000, 0))
        bad = c.choice(
            (
                Value(self._now_s + c.choice((0.004, 0.3, 1e6)), 1, drive(999, 0)).pack(),
                good.pack()[: c.randint(0, 20)],
                json.dumps([self._now_s, 1, "drive", "", 5000, 0, 0, ""]).encode(),
                json.dumps([None, 1, "drive", "", 500, 0, 0, ""]).encode(),
                c.randbytes(c.randint(0, 60)),
            )
        )
        if c.random() < 0.5:
            one = c.choice(self._inputs)
            try:
                one.life.take(bad)
            except BadValue:
                self._restart(one)
                return
        else:
            name = c.choice(_MODES)
            try:
                self._modes[name].take(bad)
            except BadValue:
                self._restart_mode(name)
                return
        raise Violation(f"taken: {bad!r}")

    def _plugin_restarts(self) -> None:
        if self._chance.random() < 0.5:
            self._restart(self._chance.choice(self._inputs))
        else:
            self._restart_mode(self._chance.choice(_MODES))

    # -- the board --

    def _follow_orders(self) -> None:
        for action in self._link.orders:
            if action == codes.ARM and self._chance.random() < 0.95:
                self._become(codes.ARMED)
            elif action in (codes.DISARM, codes.EMERGENCY_STOP):
                self._become(codes.DISARMED)
        self._link.orders.clear()

    def _become(self, state: int) -> None:
        if state != codes.ARMED:
            self.oracle.stops()
        self.oracle.armed = state == codes.ARMED
        self._link.now = replace(self._link.now, state=state)
        self._control.update()
        if self._control._arbiter.owner is None:
            self._own(None)

    def _board_changes(self) -> None:
        if self._chance.random() < 0.7:
            self._become(self._chance.choice((codes.DISARMED, codes.ARMING)))
            return
        self.oracle.stops()
        self._session += 1
        self._link.begin(self._session)
        self._control.update()


def fuzz(messages: int, first_seed: int = 1) -> tuple[int, int]:
    """Run until this many messages were sent; returns how many, and motions judged. Violation."""
    sent, judged, seed = 0, 0, first_seed
    while sent < messages:
        run = Fuzz(seed)
        try:
            run.run(min(_RUN, messages - sent))
        except Violation as found:
            raise Violation(f"seed {seed}, message {run.messages}: {found}") from None
        sent, judged, seed = sent + run.messages, judged + run.oracle.judged, seed + 1
    return sent, judged


def main() -> int:
    """1 at the first violation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    try:
        sent, judged = fuzz(options.messages, options.seed)
    except Violation as found:
        print(found)
        return 1
    print(f"{sent} messages, {judged} motions judged, no violation")
    return 0


if __name__ == "__main__":
    sys.exit(main())
