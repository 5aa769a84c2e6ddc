"""The board's state as sent to the web pages."""

from __future__ import annotations

from typing import Any

from gazechair.board.board_commands import Bypass
from gazechair.board.state import BoardState, BoardStats
from gazelink import codes


def board_fields(state: BoardState | None) -> dict[str, Any]:
    """`state` as sent to a page, numbers by name; None: not connected."""
    if state is None:
        return {
            "state": "disarmed",
            "motion": "stopped",
            "override": "none",
            "arm_reason": "not_connected",
            "decisions": dict.fromkeys(codes.DIRECTIONS, "unknown"),
            "relay_checked": True,  # nothing known against it: "board" shows what is wrong
            "tuned": None,
        }
    return {
        "state": state.state_name,
        "motion": state.motion_name,
        "override": state.override_name,
        "arm_reason": state.arm_reason_name,
        "decisions": state.decision_names,
        "relay_checked": state.relay_checked,
        "tuned": state.tuned,
    }


def bypass_ms(bypass: Bypass | None, stats: BoardStats | None) -> int:
    """Remaining ms of `bypass`: the board counts it down and sends it once a second."""
    return 0 if bypass is None or stats is None else stats.counters["bypass_ms"]
