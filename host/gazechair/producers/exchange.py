"""Messages between a producer's process and the daemon: small JSON, checked on arrival.

Daemon to process: {"at_s", "press", "target", "settings", "may_reverse", "cap_permille"}; press 0
while its mode is not pressed, the present speed cap; also "ask", the spot chosen in the picture:
{"number", "at", "settings", "may_reverse", "at_s"}. Process to daemon, a record: a plug-in's value,
with more data for the pages; "ask": number of the request it answers, 0 for the press.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gazechair.base import json_text
from gazechair.plugins.contract import NOTHING, drive
from gazechair.plugins.exchange import BadValue, Value
from gazechair.producers.contract import STATES, Output

MESSAGE_OLD_S = 0.3
"""An older message no longer proves a press."""
LONGEST = 16384
"""Bytes of a record."""
_MOST_REASON = 40


@dataclass(frozen=True)
class Record:
    """A received record."""

    value: bytes
    """For plugins.value_checks.ModeRun."""
    state: str
    reason: str
    shown: Mapping[str, Any]
    ask: int


def pack(born_s: float, press: int, output: Output, ask: int = 0) -> bytes:
    """A record as bytes."""
    intent = NOTHING if output.stick is None else drive(*output.stick)
    value = Value(born_s, press, intent).pack().decode()
    shown = dict(output.shown)
    fields = {"state": output.state, "reason": output.reason, "shown": shown, "ask": ask}
    return json.dumps({"value": value, **fields}).encode()


def unpack(payload: bytes) -> Record:
    """The record in `payload`. Raises BadValue."""
    try:
        fields = json_text.parse(payload)
        value, shown = fields["value"].encode(), fields["shown"]
        state, reason, ask = fields["state"], fields["reason"], fields["ask"]
        json.dumps(shown, allow_nan=False)  # no page could read it
    except (ValueError, TypeError, KeyError, AttributeError):
        raise BadValue("no record") from None
    if state not in STATES or not isinstance(shown, dict):
        raise BadValue("a state that there is not")
    if not isinstance(reason, str) or len(reason) > _MOST_REASON:
        raise BadValue("a reason that there is not")
    if type(ask) is not int:
        raise BadValue("an ask that there is not")
    return Record(value, state, reason, shown, ask)
