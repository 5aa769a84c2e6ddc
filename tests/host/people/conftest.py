"""A pairing desk in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazechair.base.health import Health
from gazechair.people.pairing import Paired, PairingDesk, Rejected


class Desk(PairingDesk):
    """A pairing desk whose times the test sets."""

    def __init__(self, folder: Path, health: Health | None = None) -> None:
        self.now_s = 1000.0
        self.wall_s = 1.8e9
        super().__init__(folder, lambda: self.now_s, lambda: self.wall_s, health)

    def join(self, role: str = "driver", name: str = "tablet") -> Paired:
        """Pair a device as it should be done."""
        paired = self.pair(self.new_code(role).text, name, "192.0.2.1")
        assert isinstance(paired, Paired)
        return paired

    def guess(self, code: str = "2222-2222", address: str = "192.0.2.66") -> str:
        """The reason for refusing that code."""
        rejected = self.pair(code, "x", address)
        assert isinstance(rejected, Rejected)
        return rejected.reason


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path / "state")


@pytest.fixture
def again(tmp_path: Path) -> type[Desk]:
    """Makes the desk of a host that was started again."""
    return Desk
