"""Messages of a page: the valid forms, a table of invalid ones, and arbitrary JSON."""

import contextlib
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gazechair.driving.messages import (
    DISARM,
    EMERGENCY,
    END_BYPASS,
    RELEASE,
    STOP,
    Arm,
    BadMessage,
    Beat,
    Call,
    Cap,
    Drive,
    HoldBypass,
    Reset,
    Take,
    parse,
)
from gazelink import codes

PULL = {"k": "drive", "linear": -400, "turn": 1000, "edge": 3, "token": 17}
PASS = {"k": "bypass", "held": True, "edge": 4, "token": 17}
CMD = {"k": "cmd", "verb": "left", "mode": "step", "edge": 3, "token": 17}


@pytest.mark.parametrize(
    ("message", "meaning"),
    [
        (CMD, Drive(codes.LEFT, codes.STEP, 3, 17)),
        (
            {**CMD, "verb": "backward", "mode": "continuous"},
            Drive(codes.BACKWARD, codes.CONTINUOUS, 3, 17),
        ),
        ({**CMD, "since": 30}, Drive(codes.LEFT, codes.STEP, 3, 47)),
        ({**CMD, "since": None}, Drive(codes.LEFT, codes.STEP, 3, 17)),
        (PULL, Drive(codes.DRIVE, codes.CONTINUOUS, 3, 17, -400, 1000)),
        ({"k": "arm", "token": 0}, Arm(0)),
        ({"k": "take", "token": 1, "since": 500}, Take(501)),
        ({"k": "release"}, RELEASE),
        ({"k": "cap", "permille": 50}, Cap(50)),
        ({"k": "call", "on": True}, Call(True)),
        ({"k": "call", "on": False, "there": True}, Call(False, there=True)),
        (PASS, HoldBypass(4, 17)),
        ({"k": "bypass", "held": False}, END_BYPASS),
        ({"k": "hb", "token": 5}, Beat(5)),
        ({"k": "hb", "token": None}, Beat(None)),
        ({"k": "hb"}, Beat(None)),
        ({"k": "stop"}, STOP),
        ({"k": "disarm"}, DISARM),
        ({"k": "emergency"}, EMERGENCY),
        ({"k": "reset", "token": 17, "since": 2}, Reset(19)),
    ],
)
def test_good_messages(message: dict[str, Any], meaning: object) -> None:
    assert parse(message) == meaning


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({}, '"k" must be one of'),
        ({"k": "fly"}, '"k" must be one of'),
        ({"k": None}, '"k" must be one of'),
        ({"k": ["stop"]}, '"k" must be one of'),
        ({**CMD, "verb": "stop"}, '"verb" must be one of forward, backward, left, right'),
        ({**CMD, "verb": "drive"}, '"verb"'),
        ({**CMD, "verb": 1}, '"verb"'),
        ({**CMD, "mode": "fast"}, '"mode" must be one of step, continuous'),
        ({**CMD, "mode": ["step"]}, '"mode"'),
        ({**CMD, "edge": 0}, '"edge" must be a whole number'),
        ({**CMD, "edge": True}, '"edge"'),
        ({**CMD, "edge": 1.0}, '"edge"'),
        ({**CMD, "edge": 1 << 40}, '"edge"'),
        ({**CMD, "token": None}, '"token"'),
        ({**CMD, "token": -1}, '"token"'),
        ({**CMD, "token": "17"}, '"token"'),
        ({**CMD, "mode": "tune"}, '"mode"'),
        ({**CMD, "since": -1}, '"since" must be a whole number 0..500'),
        ({**CMD, "since": 501}, '"since"'),
        ({**CMD, "since": 0.5}, '"since"'),
        ({**PULL, "linear": 1001}, 'drive: "linear" must be a whole number -1000..1000'),
        ({**PULL, "turn": "1"}, '"turn"'),
        ({"k": "drive", "linear": 1, "turn": 1, "edge": 1}, '"token"'),
        ({"k": "take"}, 'take: "token"'),
        ({"k": "cap"}, 'cap: "permille" must be a whole number 50..1000'),
        ({"k": "cap", "permille": 49}, '"permille"'),
        ({"k": "call", "there": True}, 'call: "on" must be true or false'),
        ({"k": "call", "on": False, "there": None}, '"there"'),
        ({**PASS, "held": 1}, 'bypass: "held" must be true or false'),
        ({**PASS, "edge": 0}, '"edge"'),
        ({"k": "arm"}, 'arm: "token"'),
        ({"k": "reset"}, 'reset: "token"'),
        ({"k": "hb", "token": "x"}, 'hb: "token"'),
    ],
)
def test_bad_messages_are_refused_in_one_line(message: dict[str, Any], words: str) -> None:
    with pytest.raises(BadMessage) as refusal:
        parse(message)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("kind", ["stop", "disarm", "emergency"])
def test_a_stop_is_never_refused_for_its_details(kind: str) -> None:
    assert parse({"k": kind, "token": "nonsense", "more": []}).kind == kind  # type: ignore[union-attr]


ANY_JSON = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4)
) | st.sampled_from([[], {}, [1], {"k": "stop"}, "forward", "step"])


KEYS = [
    "k",
    "verb",
    "mode",
    "edge",
    "token",
    "since",
    "linear",
    "turn",
    "held",
    "permille",
    "on",
    "there",
]


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # machines stall
@given(
    st.dictionaries(st.sampled_from(KEYS), ANY_JSON),
    st.sampled_from(["cmd", "arm", "hb", "drive", "bypass", "cap", None]),
)
def test_any_json_object_is_understood_or_refused(message: dict[str, Any], kind: Any) -> None:
    with contextlib.suppress(BadMessage):
        parse({**message, "k": kind} if kind else message)
