"""Whoever drives notices nothing of the log: not of one that records, nor of one that hangs."""

from __future__ import annotations

from gazechair.blackbox import ring as module
from gazechair.blackbox.ring import Ring
from gazesim.lockstep_chair import Lockstep


class Hanging:
    """The line to a process that does not read: its disk hangs."""

    def send(self, _batch: bytes) -> None:
        raise BlockingIOError


def drive(ring: Ring | None) -> list[tuple[int, int]]:
    """The wipers in each millisecond."""
    chair = Lockstep()
    assert chair.host is not None
    wipers: list[tuple[int, int]] = []
    chair.watchers.append(lambda: wipers.append(chair.wipers()))
    if ring is not None:

        def witness(way: str, at_s: float, frame: bytes) -> None:
            ring.put(way, at_s, frame)
            ring.hand_over(Hanging())  # type: ignore[arg-type]

        chair.host.link.protocol.witness = witness
    chair.drive(ms=400)
    chair.page.release()
    chair.run(300)
    chair.page.press("left", "step")
    chair.run(1200)
    return wipers


def test_a_disk_that_hangs_changes_no_output(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    """Neither while records wait, nor when there is no room for more."""
    monkeypatch.setattr(module, "KEPT", 300)
    ring = Ring()
    assert drive(ring) == drive(None)
    assert len(ring) == 300
    assert ring.dropped > 100
