"""What a page may say: the good forms, a table of bad ones, and any JSON at all."""

import contextlib
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gazechair.page_messages import (
    DISARM,
    EMERGENCY,
    RESET,
    STOP,
    Arm,
    BadMessage,
    Beat,
    Drive,
    parse,
)
from gazelink import codes

CMD = {"k": "cmd", "verb": "left", "mode": "step", "edge": 3, "token": 17}


@pytest.mark.parametrize(
    ("message", "meaning"),
    [
        (CMD, Drive(codes.LEFT, codes.STEP, 3, 17)),
        (
            {**CMD, "verb": "backward", "mode": "continuous"},
            Drive(codes.BACKWARD, codes.CONTINUOUS, 3, 17),
        ),
        ({"k": "arm", "token": 0}, Arm(0)),
        ({"k": "hb", "token": 5}, Beat(5)),
        ({"k": "hb", "token": None}, Beat(None)),
        ({"k": "hb"}, Beat(None)),
        ({"k": "stop"}, STOP),
        ({"k": "disarm"}, DISARM),
        ({"k": "emergency"}, EMERGENCY),
        ({"k": "reset"}, RESET),
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
        ({"k": "arm"}, 'arm: "token"'),
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


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # machines stall
@given(
    st.dictionaries(st.sampled_from(["k", "verb", "mode", "edge", "token"]), ANY_JSON),
    st.sampled_from(["cmd", "arm", "hb", None]),
)
def test_any_json_object_is_understood_or_refused(message: dict[str, Any], kind: Any) -> None:
    with contextlib.suppress(BadMessage):
        parse({**message, "k": kind} if kind else message)
