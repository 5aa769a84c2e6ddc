"""Logs a line whenever the board's state, override or faults change."""

from __future__ import annotations

import logging

from gazechair.board.state import BoardState
from gazelink import codes

log = logging.getLogger(__name__)


class StateLog:
    """Remembers the last state noted; call `forget` when the board is disconnected."""

    def __init__(self) -> None:
        self._last: tuple[int, int, int] | None = None

    def forget(self) -> None:
        """The next state is logged in any case."""
        self._last = None

    def note(self, state: BoardState) -> None:
        """Log `state` if it differs from the last one in what matters to a person later."""
        current = (state.state, state.override, state.faults)
        if current == self._last:
            return
        self._last = current
        level = logging.WARNING if state.faults else logging.INFO
        log.log(
            level,
            "board %s at %d ms: override %s, faults %s, first %s",
            state.state_name,
            state.board_ms,
            state.override_name,
            ", ".join(fault_names(state.faults)) or "none",
            codes.reason_name(state.first_fault),
        )


def fault_names(faults: int) -> list[str]:
    """Names of the bits set, in the order of the faults table."""
    return [name for bit, name, _severity, _latched in codes.FAULTS if faults & (1 << bit)]
