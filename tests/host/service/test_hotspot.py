"""The chair's own WiFi: the calls of NetworkManager, and every refusal; nmcli is a stand-in."""

from __future__ import annotations

import configparser
import os
import signal
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from fulldisk import full
from gazechair.service import hotspot
from gazechair.service.hotspot import HotspotError

NMCLI = """#!/bin/sh
echo "$@" >> "{folder}/said"
case "$*" in
  *"{failing}"*) echo "Error: Connection activation failed: {failing}" >&2; exit 4;;
  *delete*) rm -f "{folder}/connections/gazechair.nmconnection";;
esac
"""


@pytest.fixture
def connections(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "connections"
    folder.mkdir()
    stand_in(tmp_path, monkeypatch)
    return folder


def stand_in(folder: Path, monkeypatch: pytest.MonkeyPatch, failing: str = "never") -> None:
    program = folder / "nmcli"
    program.write_text(NMCLI.format(folder=folder, failing=failing))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")


def printed(connections: Path) -> list[str]:
    return (connections.parent / "said").read_text().splitlines()


def test_on_writes_a_connection_only_root_reads_and_starts_it(connections: Path) -> None:
    text = hotspot.on("stoel van Jan", "wlan1", connections)
    file = connections / "gazechair.nmconnection"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    made = configparser.ConfigParser(interpolation=None)
    made.read_string(file.read_text())
    assert made["wifi"]["mode"] == "ap"
    assert made["connection"]["interface-name"] == "wlan1"
    assert made["ipv4"]["method"] == "shared"
    password = made["wifi-security"]["psk"]
    assert len(password) == 12
    assert printed(connections) == [
        f"connection load {file}",
        "--wait 40 connection up id gazechair",
    ]
    assert password not in "".join(printed(connections)), "on no command line"
    assert "stoel van Jan" in text
    assert password in text


def test_repeated_it_keeps_its_password_and_off_forgets_it(connections: Path) -> None:
    first = hotspot.on(folder=connections)
    assert hotspot.on(folder=connections) == first == hotspot.join(connections)
    assert "forgotten" in hotspot.off(connections)
    with pytest.raises(HotspotError, match="there is no hotspot"):
        hotspot.off(connections)
    assert hotspot.on(folder=connections) != first


@pytest.mark.parametrize("failing", ["up id", "connection"])  # the latter: it is not loaded either
def test_one_that_does_not_start_is_taken_back_with_the_reason(
    connections: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    stand_in(connections.parent, monkeypatch, failing)
    with pytest.raises(HotspotError, match="Connection activation failed"):
        hotspot.on(folder=connections)
    assert list(connections.iterdir()) == []


@pytest.mark.parametrize("failing", ["up id", "connection"])
def test_repeated_with_another_name_that_fails_it_stays_the_one_that_worked(
    connections: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    before = hotspot.on(folder=connections)
    stand_in(connections.parent, monkeypatch, failing)
    with pytest.raises(HotspotError, match="Connection activation failed"):
        hotspot.on("another", "wlan9", connections)
    assert hotspot.join(connections) == before
    assert not any("delete" in line for line in printed(connections))
    if failing == "up id":
        load, up = printed(connections)[:2]
        assert printed(connections) == [load, up] * 3  # the first, the one that failed, the first


INTERRUPTED = """#!/bin/sh
echo "$@" >> "{folder}/said"
case "$*" in
  *"{at}"*) [ -e "{folder}/once" ] || {{ touch "{folder}/once"; kill -INT $PPID; sleep 5; }};;
  *delete*) rm -f "{folder}/connections/gazechair.nmconnection";;
esac
"""


@pytest.fixture
def terminal() -> Iterator[None]:
    """Ctrl-C counts, as in a terminal; what runs in a shell's background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("terminal")
@pytest.mark.parametrize("at", ["load", "up id"])
@pytest.mark.parametrize("again", [False, True])
def test_ended_by_ctrl_c_it_is_as_it_was_before(connections: Path, at: str, again: bool) -> None:
    before = hotspot.on(folder=connections) if again else ""
    program = connections.parent / "nmcli"
    program.write_text(INTERRUPTED.format(folder=connections.parent, at=at))
    with pytest.raises(HotspotError, match="ended by Ctrl-C"):
        hotspot.on("another", folder=connections)
    if again:
        assert hotspot.join(connections) == before
        assert printed(connections)[-1].endswith("connection up id gazechair")
    else:
        assert list(connections.iterdir()) == []


def test_ended_by_ctrl_c_while_it_is_written_nothing_stays(
    connections: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(HotspotError, match="ended by Ctrl-C"):
        hotspot.on(folder=connections)
    assert list(connections.iterdir()) == []


def test_on_a_full_disk_the_one_before_keeps_its_password(
    connections: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = hotspot.on(folder=connections)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(HotspotError, match="No space left"):
        hotspot.on("another", folder=connections)
    assert hotspot.join(connections) == before


def test_without_networkmanager_it_says_what_to_install(
    tmp_path: Path, connections: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(HotspotError, match="apt install network-manager"):
        hotspot.on(folder=tmp_path / "nothing")
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    with pytest.raises(HotspotError, match="apt install network-manager"):
        hotspot.on(folder=connections)
    assert list(connections.iterdir()) == []


@pytest.mark.parametrize("ssid", ["", "x" * 33, "\u00e9" * 17])
def test_a_name_that_no_network_can_have_is_refused(ssid: str, connections: Path) -> None:
    with pytest.raises(HotspotError, match="1 to 32 bytes"):
        hotspot.on(ssid, folder=connections)


def test_a_damaged_file_is_replaced(connections: Path) -> None:
    (connections / "gazechair.nmconnection").write_bytes(b"\xff" * 100)
    assert "password" in hotspot.on(folder=connections)


def test_how_to_join_is_not_told_by_half_a_file(connections: Path) -> None:
    hotspot.on("stoel", "", connections)
    file = connections / "gazechair.nmconnection"
    file.write_text(file.read_text().replace("ssid=stoel\n", ""))
    with pytest.raises(HotspotError, match="gazechair hotspot on"):
        hotspot.join(connections)


def test_what_a_phone_reads_to_join_is_escaped() -> None:
    assert hotspot.joining('a;b:"c', "pa,ss\\") == 'WIFI:T:WPA;S:a\\;b\\:\\"c;P:pa\\,ss\\\\;;'
