"""The contract: what every plug-in must do in the virtual chair.

Only outputs count: the wipers, and what the plug-in's own process sends. Each rule has a name, a
limit in virtual time where time matters, and reports in one line what it observed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from gazechair.plugins.exchange import Facts, Value
from gazechair.plugins.found import Found
from gazecontract.chair import PluginChair
from gazecontract.paced import Failed, Paced

NEUTRAL_MS = 300  # promise P3
AT_ONCE_MS = 20  # a value's way to the wipers, and the next question
_MOVES_MS = 8000
_WATCH_MS = 1200
_MORE_PERMILLE = 1001


@dataclass(frozen=True)
class Row:
    """One rule and its result."""

    rule: str
    ok: bool
    saw: str


class _Broken(Exception):
    """Raised when a rule does not hold; the text is what was observed."""


class Contract:
    """Checks one plug-in; `rows` yields a Row for each rule."""

    def __init__(self, found: Found, settings: Mapping[str, Any] | None = None) -> None:
        """`settings` None: its own for a rehearsal."""
        self._found = found
        self._settings = settings

    def rows(self) -> Iterator[Row]:
        """Check every rule in turn; if the process fails there is only that row."""
        try:
            with Paced(self._found, {}, "describe") as paced:
                described = json.loads(paced.data())
                yield _words(paced.facts)
            settings = described["rehearsal"] if self._settings is None else self._settings
            yield from self._refuses(described["table"], settings)
            with Paced(self._found, settings) as process:
                yield from self._drives(process)
        except Failed as error:
            yield Row("its process answers", False, str(error))

    def _refuses(self, table: list[str], settings: Mapping[str, Any]) -> Iterator[Row]:
        keys = [line.split(" = ")[0] for line in table if line[:1] not in "#["]
        for wrong in [*({**settings, key: {}} for key in keys), {**settings, "no such key": 1}]:
            try:
                with Paced(self._found, wrong) as paced:
                    paced.ask({"now_s": 0.0, "press": 0, "state_s": 0.0})
            except Failed as error:
                if "must be" in str(error) or "is no setting" in str(error):
                    continue
                yield Row("a wrong setting is refused in one line", False, str(error))
            else:
                yield Row("a wrong setting is refused in one line", False, f"it took {wrong}")
            return
        yield Row("a wrong setting is refused in one line", True, f"{len(keys) + 1} of them")

    def _drives(self, process: Paced) -> Iterator[Row]:
        found = self._found
        chair = PluginChair(found.kind, found.name, process.ask)
        rules = _Rules(chair)
        for name, rule in rules.named():
            try:
                row = Row(name, True, rule())
            except _Broken as broken:
                row = Row(name, False, str(broken))
            yield row
            if name == rules.FIRST and not row.ok:
                return  # nothing else can be checked if it does not drive
            rules.calm()


def _words(facts: Facts) -> Row:
    missing = [
        f"a name in {language}" for language in ("nl", "en") if not facts.names.get(language)
    ]
    missing += [] if facts.about else ["a first line of its docstring"]
    rule = "it says what it is, in Dutch and English"
    return Row(rule, not missing, f"lacks {', '.join(missing)}" if missing else facts.about)


class _Rules:
    """The rules that are checked at the wipers."""

    FIRST = "armed, it drives the chair"

    def __init__(self, chair: PluginChair) -> None:
        self._chair = chair

    def named(self) -> list[tuple[str, Callable[[], str]]]:
        """In the order in which they are checked."""
        return [
            ("started first, it moves nothing before arming", self.unarmed),
            (self.FIRST, self.drives),
            ("what it releases is neutral", self.releases),
            ("the driver's Stop wins, and needs a new press", self.stop_wins),
            ("frozen: neutral, and its press is over", self.frozen),
            ("killed: neutral, and started again it needs a release first", self.killed),
            ("the same moment over and over: neutral", self.stale),
            ("a time from the future: neutral, and it is ended", self.future),
            ("outputs beyond full: neutral, and it is ended", self.beyond),
            ("no value at all: neutral, and it is ended", self.nonsense),
            ("an obstacle overrules it", self.obstacle),
            ("without a lidar it moves nothing, and lives on", self.blind),
        ]

    def calm(self) -> None:
        """Return to the state before the first rule, armed."""
        chair = self._chair
        chair.spoil = Value.pack
        chair.block(False)
        chair.sees = True
        chair.leave()
        chair.release()
        chair.run(300)
        if not chair.armed():
            chair.arm()
        chair.run(200)
        chair.sit()
        chair.run(60)

    # -- rules: each returns what it observed, or raises _Broken --

    def unarmed(self) -> str:
        chair = self._chair
        chair.sit()
        chair.press()
        self._until(lambda: bool(chair.app) and chair.link.state() is not None, "a board")
        moved = self._watch(1000, chair.harmless)
        if moved is not None:
            raise _Broken(f"the wipers left neutral after {moved} ms")
        return "1 s at neutral"

    def drives(self) -> str:
        took_ms = self._moves()
        chair = self._chair
        stood = (chair.world.chair.x_m, chair.world.chair.y_m, chair.world.chair.heading_deg)
        for _ in range(_MOVES_MS):
            chair.one_ms()
            here = (chair.world.chair.x_m, chair.world.chair.y_m, chair.world.chair.heading_deg)
            if sum(abs(a - b) for a, b in zip(here, stood, strict=True)) > 0.02:
                return f"wipers after {took_ms} ms, and the chair follows"
        raise _Broken("the wipers moved, the chair did not")

    def releases(self) -> str:
        chair = self._chair
        self._moves()
        if chair.value is not None and chair.value.intent.do == "step":
            return "it steps: a step ends by itself"
        if chair.kind == "mode":
            chair.release()
        else:
            self._until(lambda: bool(chair.value and not chair.value.intent.moves), "a release")
        return self._neutral_within(AT_ONCE_MS)

    def stop_wins(self) -> str:
        self._moves()
        self._chair.say(k="stop")
        saw = self._neutral_within(AT_ONCE_MS)
        self._stays(self._newer_press())
        return saw

    def frozen(self) -> str:
        chair = self._chair
        self._moves()
        chair.spoil = lambda _value: None
        saw = self._neutral_within(NEUTRAL_MS)
        chair.run(100)
        chair.spoil = Value.pack
        self._stays(self._newer_press())
        return saw

    def killed(self) -> str:
        chair = self._chair
        self._moves()
        chair.leave()
        saw = self._neutral_within(AT_ONCE_MS)
        chair.run(100)
        chair.sit()
        self._stays(self._released())
        return saw

    def stale(self) -> str:
        self._moves()
        value = self._chair.value
        assert value is not None
        self._chair.spoil = lambda later: replace(later, born_s=value.born_s).pack()
        return self._neutral_within(NEUTRAL_MS)

    def future(self) -> str:
        return self._ended(lambda value: replace(value, born_s=value.born_s + 0.1).pack())

    def beyond(self) -> str:
        def spoil(value: Value) -> bytes:
            intent = replace(value.intent, do="drive", linear_permille=_MORE_PERMILLE)
            return replace(value, intent=intent).pack()

        return self._ended(spoil)

    def nonsense(self) -> str:
        return self._ended(lambda _value: b'{"moves": NaN')

    def obstacle(self) -> str:
        self._moves()
        self._chair.block(True)
        return self._neutral_within(NEUTRAL_MS)

    def blind(self) -> str:
        chair = self._chair
        self._moves()
        chair.sees = False
        limit_ms = NEUTRAL_MS + 100  # promise P6, from the last scan's acquisition
        self._neutral_within(limit_ms)
        moved = self._watch(_WATCH_MS, chair.neutral)
        if moved is not None:
            raise _Broken(f"it moved again {moved} ms later")
        if chair.refused:
            raise _Broken(f"it was ended: {chair.refused}")
        return f"neutral within {limit_ms} ms"

    # -- helpers --

    def _ended(self, spoil: Callable[[Value], bytes]) -> str:
        chair = self._chair
        self._moves()
        chair.spoil = spoil
        saw = self._neutral_within(NEUTRAL_MS)
        if not chair.refused:
            raise _Broken("neutral, but it lives on")
        return f"{saw}: {chair.refused}"

    def _moves(self) -> int:
        chair = self._chair
        if not chair.armed():
            chair.release()
            chair.arm()
        chair.press()
        return self._until(lambda: not chair.neutral(), "wipers that leave neutral")

    def _until(self, condition: Callable[[], bool], what: str) -> int:
        chair = self._chair
        for ms in range(_MOVES_MS):
            if condition():
                return ms
            chair.one_ms()
        value = "" if chair.value is None else f"; it says {chair.value.intent}"
        reasons = f"; refused: {', '.join(sorted(chair.reasons))}" if chair.reasons else ""
        ended = f"; ended: {chair.refused}" if chair.refused else ""
        raise _Broken(f"no {what} within {_MOVES_MS / 1000:g} s{value}{reasons}{ended}")

    def _watch(self, ms: int, condition: Callable[[], bool]) -> int | None:
        for k in range(ms):
            self._chair.one_ms()
            if not condition():
                return k
        return None

    def _neutral_within(self, limit_ms: int) -> str:
        for ms in range(limit_ms + 1):
            if self._chair.neutral():
                return f"neutral after {ms} ms (at most {limit_ms})"
            self._chair.one_ms()
        raise _Broken(f"not neutral within {limit_ms} ms; {self._chair.why()}")

    def _newer_press(self) -> Callable[[], bool]:
        """A function: has the person pressed again since now? On the page nobody does."""
        chair = self._chair
        press = chair.value.press if chair.value is not None else 0
        return lambda: chair.kind == "input" and bool(chair.value and chair.value.press != press)

    def _released(self) -> Callable[[], bool]:
        """A function: has the person let go of the input since now?"""
        chair = self._chair
        seen: list[bool] = []

        def released() -> bool:
            if chair.kind == "input" and chair.value and chair.value.intent.do == "nothing":
                seen.append(True)
            return bool(seen)

        return released

    def _stays(self, may_move: Callable[[], bool]) -> None:
        """Check that the wipers stay at neutral until a new press."""
        for ms in range(_WATCH_MS):
            self._chair.one_ms()
            if may_move():
                return
            if not self._chair.neutral():
                raise _Broken(f"the press that ended moved the chair again, {ms} ms later")
