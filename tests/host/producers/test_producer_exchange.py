"""Records of a producer's process: accepted as a whole, or refused."""

from __future__ import annotations

import json

import pytest

from gazechair.plugins.exchange import BadValue
from gazechair.producers import exchange
from gazechair.producers.contract import Output

SHOWN = {"left_m": 1.5, "px": [[0.5, 0.5]]}


def test_what_is_packed_arrives() -> None:
    sent = Output((300, -20), "drives", "", SHOWN)
    record = exchange.unpack(exchange.pack(12.5, 7, sent, 3))
    assert (record.state, record.reason, record.shown, record.ask) == ("drives", "", SHOWN, 3)
    assert b"12.5" in record.value


@pytest.mark.parametrize(
    "changed",
    [
        {"shown": {"left_m": float("nan")}},
        {"shown": {"px": [[float("inf"), 0.0]]}},
        {"shown": []},
        {"state": "flies"},
        {"state": ["drives"]},
        {"reason": "x" * 41},
        {"reason": None},
        {"ask": 1.0},
        {"ask": True},
        {"value": 1},
        {"value": None},
    ],
)
def test_what_no_page_could_read_is_no_record(changed: dict[str, object]) -> None:
    fields = json.loads(exchange.pack(12.5, 7, Output(None, "thinks", "", SHOWN), 3))
    with pytest.raises(BadValue):
        exchange.unpack(json.dumps(fields | changed).encode())


@pytest.mark.parametrize("payload", [b"", b"\xff" * 9, b"[" * 100_000, b"{}", b"7", b"null"])
def test_bytes_that_are_no_record_are_refused(payload: bytes) -> None:
    with pytest.raises(BadValue):
        exchange.unpack(payload)
