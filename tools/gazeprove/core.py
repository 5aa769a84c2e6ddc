"""The real safety and motion objects, ticking from one abstract state after another."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import Any

from gazeboard.core import ages
from gazeboard.core.motion import Motion
from gazeboard.core.tick import Tick
from gazelink import codes
from gazeprove.abstract import (
    AT,
    AUTO,
    AUTO_AT,
    AUTO_FIELDS,
    COMPARED,
    ELAPSED,
    FIELDS,
    FORGOTTEN,
    HIGHEST,
    PASSING,
    PLAIN,
    WORDS,
    WORDS_AT,
    WORDS_TOO,
    Named,
    State,
    abstracted,
    auto_passable,
    auto_values,
    can_pass,
    get,
    motion_values,
    step_can_pass,
)
from gazeprove.around import Around
from gazeprove.either import Coin, Either
from gazeprove.inputs import Choices


@dataclass
class Loaded:
    """What is the same in every tick from a state; some counters may pass, see Core.load()."""

    attributes: dict[str, Any]
    words: list[Any]
    motion: tuple[Any, ...]
    auto: tuple[Any, ...]
    was: dict[str, Any]  # fields of safety
    coins: tuple[Coin, ...]
    places: tuple[int, ...]  # of the counters in a state


@dataclass
class Core:
    """The real safety and motion objects, loaded with one state after another."""

    safety: Named
    motion: Motion
    around: Around
    relay_follows: bool  # the contact always does what the enable line says
    choices: Choices
    tick: Tick = field(init=False)
    state: State = ()  # from which it ticks
    passable: tuple[tuple[int, str], ...] = ()  # counters, with their places in PASSING
    auto_passable: tuple[str, ...] = ()
    step_can_pass: bool = False
    _known: dict[tuple[Any, ...], State] = field(default_factory=dict)  # what was abstracted
    _loaded: dict[tuple[str, ...], Loaded] = field(default_factory=dict)  # from one state
    _coins: list[Coin] = field(default_factory=list)  # of this tick
    _places: list[int] = field(default_factory=list)  # of the counters that they decide in a state

    def __post_init__(self) -> None:
        self.tick = self.around.tick(self.safety, self.motion)

    def begin(self, state: State) -> None:
        """All ticks from now on are from `state`."""
        safety = self.safety
        if type(safety._words) is not list:  # but machine words: none of them can be Either
            safety._words = safety.ages.words = safety.auto._words = [*safety._words]
        self.state = state
        self.passable = tuple(
            (at, name) for at, name in enumerate(PASSING) if can_pass(state, name)
        )
        self.auto_passable = auto_passable(state)
        self.step_can_pass = step_can_pass(state)
        self._loaded.clear()

    def load(self, passing: tuple[str, ...], elapsed: bool) -> dict[str, Any]:
        """Become the state, each counter of `passing` at either end of its class.

        `elapsed`: a step has taken all the time of its class. Returns safety's fields.
        """
        now = self._loaded.get(passing)
        if now is None:
            now = self._loaded[passing] = self._prepared(passing)
        self._coins = [*now.coins]
        self._places = [*now.places]
        for coin in now.coins:
            coin.side = -1
        safety, motion = self.safety, self.motion
        safety.__dict__.update(now.attributes)
        safety._words[:] = now.words
        motion.stop()
        motion._edge, motion._elapsed_ms, motion.state, motion._drives_straight = now.motion
        safety.auto.left_ms, safety.auto.overruled_ms = now.auto
        if elapsed:
            motion._elapsed_ms = ELAPSED[safety._verb][1][motion._elapsed_ms]
        return now.was

    def _prepared(self, passing: tuple[str, ...]) -> Loaded:
        state = self.state
        words = self.safety._words[:]
        for at in COMPARED:
            words[at] = 0
        for at, value in zip(WORDS_AT, state[len(PLAIN) :], strict=False):
            words[at] = value
        if get(state, "state") != codes.DISARMED:
            # Not known: if this tick does not set them back to 0, they may be anything.
            words[ages.IDLE] = words[ages.NEUTRAL] = 1
        auto = dict(zip(AUTO_FIELDS, state[AUTO_AT:], strict=True))
        coins = [Coin(self.choices) for _ in passing]
        places = []
        for name, coin in zip(passing, coins, strict=True):
            if name in AUTO:
                auto[name] = Either(coin, auto[name], AUTO[name][1][auto[name]])
                places.append(AUTO_AT + AUTO_FIELDS.index(name))
            else:
                at = WORDS[name]
                words[at] = Either(coin, words[at], HIGHEST[name][state[AT[name]]])
                places.append(AT[name])
        plain = dict(zip(PLAIN, state, strict=False))
        was = {**plain, **{name: words[WORDS[name]] for name in WORDS_TOO}}
        return Loaded(
            {**plain, **FORGOTTEN},
            words,
            state[len(FIELDS) : AUTO_AT],
            tuple(auto.values()),
            was,
            tuple(coins),
            tuple(places),
        )

    def may_be(self, name: str, number: int) -> None:
        """If a counter is not 0, it may as well be this."""
        safety = self.safety
        now = getattr(safety, name)
        if type(now) is Either:
            if now and self.choices.pick(2):
                setattr(safety, name, number)
        elif now:
            coin = Coin(self.choices)
            self._coins.append(coin)
            self._places.append(AT[name])
            setattr(safety, name, Either(coin, now, number))

    def together(self) -> int:
        """How many ticks the last one was: one for each side of each coin that nobody tossed."""
        return 1 << sum([coin.side < 0 for coin in self._coins])

    def toss(self) -> None:
        """Choose what is not chosen yet."""
        for coin in self._coins:
            coin.toss()

    def seen(self) -> tuple[Any, ...]:
        """What the objects are now: a number, or the two between which nobody has chosen."""
        safety = self.safety
        found = [*safety.values(), *motion_values(self.motion), *auto_values(safety.auto)]
        for at in self._places:
            if type(found[at]) is Either:
                found[at] = found[at].seen()
        return tuple(found)

    def read(self) -> State:
        """The abstraction of what the objects are now, when all is chosen."""
        return self._abstracted(self.seen())

    def states(self, seen: tuple[Any, ...]) -> list[State]:
        """The abstractions of all that what was seen may be."""
        numbers = (value if type(value) is tuple else (value,) for value in seen)
        return [self._abstracted(values) for values in product(*numbers)]

    def _abstracted(self, seen: tuple[Any, ...]) -> State:
        state = self._known.get(seen)
        if state is None:
            fitted = self.safety._relay_fitted
            state = self._known[seen] = abstracted(seen, self.relay_follows, fitted)
        return state
