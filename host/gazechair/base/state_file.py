"""One file of the state folder: replaced as a whole; its health reports when it is damaged."""

from __future__ import annotations

from pathlib import Path

from gazechair.base.health import DEGRADED, OK, Health
from gazechair.base.reasons import FILE_DAMAGED, NOT_KEPT
from gazechair.base.state_folder import replace_file


class StateFile:
    """Replaced as a whole. A damaged one keeps its place until then, and a copy stays after it.

    One thread at a time reads or replaces it.
    """

    def __init__(self, path: Path, health: Health, reason: str = FILE_DAMAGED) -> None:
        """`reason`: the health's, while the file is damaged."""
        self.path = path
        self._health = health
        self._reason = reason
        self._aside = False
        self.sound()

    @property
    def problem(self) -> str:
        """What is not known, or not kept, in one line; "" when all is."""
        return self._health.detail

    def sound(self) -> None:
        """Report that all of the file can be used, or that there is none."""
        self._aside = False
        self._health.set(OK)

    def damaged(self, what: str, state: str = DEGRADED, aside: bool = True) -> None:
        """Report `what` cannot be used; `aside` False: the next content holds it unchanged."""
        self._aside = aside
        self._health.set(state, self._reason, f"{self.path}: {what}")

    def replace(self, content: bytes, durable: bool = True) -> None:
        """Write the file; it is sound then, if `durable`. Raises OSError."""
        replace_file(self.path, content, durable, self._aside)
        self._aside = False
        if durable:
            self._health.set(OK)

    def not_kept(self, error: OSError, so: str) -> None:
        """Report that `replace` raised `error`; `so`: what that means."""
        self._health.set(DEGRADED, NOT_KEPT, f"{self.path}: {error.strerror}; {so}")
