"""The arbiter's clients: pages, and inputs alongside them; when they stopped the chair."""

from __future__ import annotations

from dataclasses import dataclass, field

from gazelink import codes

# A viewer can never own the chair.
ROLES = {"driver": codes.DRIVER, "caretaker": codes.CARETAKER, "viewer": codes.NOBODY}


@dataclass
class Client:
    role: int  # as owner: codes.DRIVER, ...
    role_name: str
    received_s: float
    is_input: bool = False  # else a page
    refused: set[str] = field(default_factory=set)  # refusals already sent about its newest press
    bypass_refused: int = 0  # edge of a bypass already refused


class Stops:
    """When clients last sent a stop of any kind, connected or not; monotonic seconds."""

    def __init__(self) -> None:
        self._newest_s, self._newest_by = 0.0, 0
        self._before_s = 0.0  # the newest of everybody else

    def sent(self, client: int, now_s: float) -> None:
        """`client` has sent a stop."""
        if client != self._newest_by:
            self._before_s, self._newest_by = self._newest_s, client
        self._newest_s = now_s

    def of_others_s(self, client: int) -> float:
        """The newest of anyone but `client`, whose own messages arrive in order; 0: anyone's."""
        return self._before_s if client == self._newest_by else self._newest_s
