"""Messages to systemd: none without it, and no sign of life while the arbiter hangs."""

from __future__ import annotations

import os
import socket
from pathlib import Path
from types import SimpleNamespace

import pytest

from gazechair.base.service_manager import ServiceManager
from gazechair.daemon import Daemon


def test_it_hears_each_word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = str(tmp_path / "notify")
    monkeypatch.setenv("NOTIFY_SOCKET", place)
    monkeypatch.setenv("WATCHDOG_USEC", "5000000")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as received:
        received.bind(place)
        manager = ServiceManager()
        manager.ready("https://chair")
        manager.alive()
        manager.ending()
        words = [received.recv(100) for _ in range(3)]
    assert words == [b"READY=1\nSTATUS=https://chair", b"WATCHDOG=1", b"STOPPING=1"]
    assert manager.pace_s == 1.0
    assert "NOTIFY_SOCKET" not in os.environ, "a child process could speak for the daemon"


def test_a_short_watchdog_is_answered_twice_in_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "1000000")
    assert ServiceManager().pace_s == 0.5


@pytest.mark.parametrize("address", [None, "/nowhere/notify", "@gazechair-nobody"])
def test_nobody_listens(address: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    if address is not None:
        monkeypatch.setenv("NOTIFY_SOCKET", address)
    ServiceManager().alive()


@pytest.mark.parametrize(("stood_s", "alive"), [(0.0, True), (1.9, True), (2.1, False)])
def test_a_daemon_whose_arbiter_stands_is_not_alive(
    stood_s: float, alive: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gazechair.daemon.time.monotonic", lambda: 100.0 + stood_s)
    daemon = SimpleNamespace(control=SimpleNamespace(alive_s=100.0))
    assert Daemon.alive.fget(daemon) is alive
