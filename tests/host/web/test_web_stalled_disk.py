"""A disk that stalls holds up the requests that wait for it, and nobody else."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

LONG_S = 20.0


class Stalled:
    """In place of a function that writes: it waits for the gate."""

    def __init__(self, function: Any) -> None:
        self._function = function
        self.waiting = threading.Semaphore(0)
        self.gate = threading.Event()

    def __call__(self, *arguments: Any) -> Any:
        self.waiting.release()
        assert self.gate.wait(LONG_S)
        return self._function(*arguments)


def test_while_a_pairing_is_stored_a_paired_driver_comes_back(
    desk: Any, visitor: Any, driver: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    nobody, other = visitor(None), visitor(None)
    posted = {"code": desk.new_code("caretaker").text}
    stalled = Stalled(desk.pair)
    monkeypatch.setattr(desk, "pair", stalled)
    with ThreadPoolExecutor(1) as pool:
        pairing = pool.submit(nobody.post, "/pair", posted)
        try:
            assert stalled.waiting.acquire(timeout=LONG_S)
            assert driver.open().next()["k"] == "welcome"
            assert driver.get("/")[0] == 200
            assert other.get("/pair")[0] == 200
        finally:
            stalled.gate.set()
        assert pairing.result()[0] == 200


def test_while_profiles_are_stored_their_role_comes_back(
    port: Any, driver: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    stalled = Stalled(lambda _request, _role: {"revision": 1})
    monkeypatch.setattr(port, "change_profile", stalled, raising=False)
    with ThreadPoolExecutor(2) as pool:
        changes = [pool.submit(driver.post, "/profiles", {"choose": "1"}) for _ in range(2)]
        try:
            for _ in changes:
                assert stalled.waiting.acquire(timeout=LONG_S)
            assert driver.open().next()["k"] == "welcome"
            assert driver.get("/")[0] == 200
        finally:
            stalled.gate.set()
        assert [change.result()[0] for change in changes] == [200, 200]
