"""What is tried in one tick for both is what is found when each is tried by itself."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import pytest

from gazeboard.core import limits
from gazeboard.core.motion import Motion
from gazeboard.core.safety import Safety
from gazelink import codes
from gazeprove.core import Core
from gazeprove.either import Coin, Either
from gazeprove.explore import Explored, explore
from gazeprove.inputs import Choices, Scope

QUESTIONS: tuple[Callable[[Any], Any], ...] = (
    *(
        lambda n, ask=ask, to=to: ask(n, to)
        for ask in (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne)
        for to in (-1, 0, 5, 6, 299, 300, 301)
    ),
    bool,
    lambda n: bool(n - 5),
    lambda n: n + 1 == 300 or n + 1 > 7,
    lambda n: 0 < n - 5 < 295,
    lambda n: n >= 5 and n - 1 != 299,
    lambda n: n - 1 == n - 1,
    lambda n: n - 1 == n - 2,
)


def answers(asks: Callable[[Choices], Any]) -> list[Any]:
    """What is answered in each leaf of the choices."""
    choices = Choices()
    found = []
    while True:
        found.append(asks(choices))
        if not choices.following():
            return found


@pytest.mark.parametrize("question", QUESTIONS)
def test_an_answer_is_a_choice_just_where_it_would_differ(question: Callable[[Any], Any]) -> None:
    expected = [question(5), question(299)]
    found = answers(lambda choices: question(Either(Coin(choices), 5, 299)))
    assert found == (expected[:1] if expected[0] == expected[1] else expected)


def test_what_was_chosen_stays_and_holds_for_all_that_depends_on_it() -> None:
    def asks(choices: Choices) -> Any:
        number = Either(Coin(choices), 5, 299)
        before, later = number.seen(), number + 1
        assert before == (5, 299)
        return number > 100, later.seen(), number > 100, later < 300, later == number + 1

    assert answers(asks) == [(False, 6, False, True, True), (True, 300, True, False, True)]


def test_what_could_be_wrong_in_silence_is_refused() -> None:
    number, other = (Either(Coin(Choices()), 5, 299) for _ in range(2))
    wrong: tuple[Callable[[], Any], ...] = (
        lambda: number == other,
        lambda: {number},
        lambda: int(number),  # type: ignore[call-overload]
        lambda: range(number),  # type: ignore[call-overload]
        lambda: number & 1,  # type: ignore[operator]
        lambda: 1 << number,  # type: ignore[operator]
    )
    for does in wrong:
        with pytest.raises(TypeError):
            does()


def one_by_one(scope: Scope) -> Explored:
    """The exploration in which each number is chosen before the tick begins."""
    with pytest.MonkeyPatch.context() as patch:
        load, may_be = Core.load, Core.may_be

        def loaded(core: Core, *of: Any) -> dict[str, Any]:
            was = load(core, *of)
            core.toss()
            return was

        def was_or_is(core: Core, *of: Any) -> None:
            may_be(core, *of)
            core.toss()

        patch.setattr(Core, "load", loaded)
        patch.setattr(Core, "may_be", was_or_is)
        return explore(scope)


def pairs(found: Explored) -> set[tuple[Any, Any]]:
    """The transitions, by the states themselves."""
    states = list(found.states)
    return {(states[before], states[after]) for before, after in found.edges}


def never(*causes: str) -> Scope:
    """A small one: what boot found keeps it from driving."""
    faults = 1 << codes.NO_HARD_TIMER
    return Scope("never", frozenset(causes), boot_faults=faults, never_drives=True)


@pytest.mark.parametrize(
    "scope",
    [
        never(),
        *(
            pytest.param(scope, marks=pytest.mark.costly)
            for scope in (never("late"), never("host"), never("exception"), Scope("drives"))
        ),
    ],
    ids=lambda scope: "+".join((scope.name, *scope.causes)),
)
def test_the_same_states_and_transitions_are_found(scope: Scope) -> None:
    found, expected = explore(scope), one_by_one(scope)
    assert not found.broken
    assert not expected.broken
    assert set(found.states) == set(expected.states)
    assert pairs(found) == pairs(expected)
    assert found.transitions == expected.transitions == expected.ticks
    assert found.ticks < 0.6 * expected.ticks
    assert found.dead_ends == expected.dead_ends


def broken(scope: Scope) -> set[str]:
    """The invariants that do not hold."""
    return {story.split()[0] for story in explore(scope).broken}


def test_an_invariant_asks_for_itself_what_the_core_forgot_to_ask(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(limits, "HOST_SILENT_MS", limits.AGE_MAX_MS)
    assert "faults_say_what_is" in broken(never("host"))


@pytest.mark.parametrize(
    ("of", "name", "does", "invariant"),
    [
        (Safety, "_why_not_move", lambda *_: codes.NO_REASON, "motion_only_when_armed"),
        (Safety, "_disarm", lambda *_: None, "disarming_is_never_lost"),
        (Safety, "_why_not_arm", lambda *_: codes.NO_REASON, "arming_needs_everything"),
        (Safety, "_relay_proven", lambda *_: True, "armed_needs_the_relay"),
        (Safety, "_spend", lambda *_: None, "armed_needs_the_relay"),
        (Safety, "_end_press", lambda *_: None, "every_refusal_has_a_reason"),
        (Motion, "_halt", lambda *_: None, "motion_only_by_a_live_press"),
    ],
)
def test_a_broken_core_breaks_what_it_must_keep(
    of: type, name: str, does: Any, invariant: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(of, name, does)
    assert invariant in broken(Scope("drives"))
