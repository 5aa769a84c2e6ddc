"""Messages of a plug-in's process: every valid value is accepted, nothing else."""

from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.plugins import NOTHING, STOP, Input, Intent, Mode, caller, choose, drive, hold, step
from gazechair.plugins.exchange import (
    LONGEST,
    BadValue,
    Facts,
    Value,
    unpack,
    unpack_facts,
)

INTENTS = (NOTHING, STOP, hold("left"), step("backward"), drive(-1000, 3), choose("follow"))
GOOD = json.loads(Value(1.5, 2, drive(5, -5), 3, "dull").pack())


@pytest.mark.parametrize("intent", INTENTS, ids=lambda intent: intent.do)
def test_a_value_arrives_as_it_was(intent: Intent) -> None:
    value = Value(12.25, 7, intent, 3, "its battery is low")
    assert unpack(value.pack()) == value


@pytest.mark.parametrize(
    ("at", "wrong"),
    [
        (0, "12"),
        (0, float("nan")),
        (0, float("inf")),
        (0, 12),
        (1, -1),
        (1, True),
        (1, 1 << 40),
        (2, "fly"),
        (2, None),
        (3, 5),
        (4, 1001),
        (5, -1001),
        (5, 0.5),
        (6, None),
        (7, 1),
    ],
)
def test_a_wrong_field_is_refused(at: int, wrong: object) -> None:
    with pytest.raises(BadValue):
        unpack(json.dumps([*GOOD[:at], wrong, *GOOD[at + 1 :]]).encode())


def test_a_direction_that_there_is_not_is_refused() -> None:
    with pytest.raises(BadValue, match="direction"):
        unpack(json.dumps([1.0, 1, "hold", "up", 0, 0, 0, ""]).encode())
    for wrong in (lambda: hold("up"), lambda: step(""), lambda: drive(1001, 0)):
        with pytest.raises(ValueError, match="not"):
            wrong()
    with pytest.raises(ValueError, match="not"):
        drive(0.5, 0)  # type: ignore[arg-type]


@given(st.binary(max_size=60) | st.recursive(st.none() | st.floats() | st.text(), st.lists).map(
    lambda v: json.dumps(v).encode()
))  # fmt: skip
def test_no_bytes_do_more_than_be_refused(payload: bytes) -> None:
    with contextlib.suppress(BadValue):
        unpack(payload)
    with contextlib.suppress(BadValue):
        unpack_facts(payload)


def test_a_deep_or_long_one_is_refused() -> None:
    for payload in (b"[" * 3000, b"9" * 5000, b"[" + b"1," * 200 + b"1]"):
        with pytest.raises(BadValue):
            unpack(payload)


def test_facts_are_cut_to_what_fits_on_a_tile() -> None:
    facts = unpack_facts(Facts("a\nb" * 100, "●●●●●●", {"nl": "x" * 99, "en": "y\x00z"}).pack())
    assert facts.icon == "●●●●"
    assert facts.names == {"nl": "x" * 20, "en": "y z"}
    assert facts.about.isprintable()


def test_the_longest_honest_value_fits_its_record() -> None:
    value = Value(123456789.123456789, 1 << 31, Intent("choose", "x" * 20), 1 << 31, "🪑" * 999)
    assert len(value.pack()) <= LONGEST
    assert unpack(value.pack()).trouble.startswith("🪑🪑🪑")


def test_an_input_that_senses_nothing_and_a_mode_that_drives_nowhere_cannot_be_built() -> None:
    """Known as the process starts, not at the first press."""

    class Deaf(Input):
        """Has no sense()."""

    class Still(Mode):
        """Has no drive()."""

    for plugin, missing in ((Deaf, "sense"), (Still, "drive")):
        with pytest.raises(TypeError, match=missing):
            caller.build(plugin, "it", {})
