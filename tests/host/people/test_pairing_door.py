"""The daemon's side door, through which `gazechair pair` asks; and what a terminal shows."""

from __future__ import annotations

import errno
import json
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gazechair.base.user_error import UserError
from gazechair.people.pairing import Paired, local
from gazechair.people.pairing.local import SOCKET_NAME, LocalDoor, NotRunning, ask
from gazechair.people.pairing.store import StoreError
from gazechair.service import pair
from gazedemo import pairing
from patience import wait_until

URL = "https://chair.local:8443/pair"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / ("deep" * 30) / "state"  # longer than a unix socket's path may be


@pytest.fixture
def door(again: Any, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.setattr(local, "_LOOK_S", 0.02)  # ends sooner
    desk = again(folder)
    door = LocalDoor(desk, folder, lambda: URL)
    door.start()
    yield desk
    door.stop()


def test_a_code_is_made_and_used(door: Any, folder: Path) -> None:
    made = ask(folder, {"ask": "code", "role": "caretaker"})
    assert (made["role"], made["url"], made["valid_s"]) == ("caretaker", URL, 600.0)
    assert ask(folder, {"ask": "open", "code": made["code"]}) == {"open": True}
    assert isinstance(door.pair(made["code"], "phone", "192.0.2.1"), Paired)
    assert ask(folder, {"ask": "open", "code": made["code"]}) == {"open": False}
    devices = ask(folder, {"ask": "list"})["devices"]
    assert [(d["role"], d["name"]) for d in devices] == [("caretaker", "phone")]
    assert ask(folder, {"ask": "revoke", "id": devices[0]["id"]}) == {"revoked": True}
    assert ask(folder, {"ask": "list"}) == {"devices": [], "problem": ""}


@pytest.mark.parametrize(
    "request_line",
    [
        b"",
        b"\n",
        b"{}\n",
        b"[1]\n",
        b'{"ask": "code", "role": "king"}\n',
        b'{"ask": "code", "role": "driver", "valid_s": 1e9}\n',
        b'{"ask": "code", "role": "driver", "valid_s": NaN}\n',
        pytest.param(
            b'{"ask": "code", "role": "driver", "valid_s": 1' + b"0" * 400 + b"}\n", id="huge"
        ),
        b'{"ask": "revoke"}\n',
        b"\xff\xfe\n",
        b"x" * 100_000,
    ],
)
def test_nonsense_is_refused_and_the_door_stays_open(
    door: Any, folder: Path, request_line: bytes
) -> None:
    with socket.socket(socket.AF_UNIX) as client:
        handle = os.open(folder, os.O_RDONLY)
        client.connect(f"/proc/self/fd/{handle}/{SOCKET_NAME}")
        os.close(handle)
        client.settimeout(20)
        try:
            client.sendall(request_line)
            client.shutdown(socket.SHUT_WR)
            assert "error" in json.loads(client.recv(4096))
        except OSError:
            assert len(request_line) > 50_000  # cut off while it still talked
    assert ask(folder, {"ask": "list"}) == {"devices": [], "problem": ""}


@pytest.mark.parametrize("answer", [b'{"error": "too many are paired"}', b"[]", b"7"])
def test_a_refusal_is_told_by_all_who_ask(folder: Path, answer: bytes) -> None:
    folder.mkdir(parents=True)
    handle = os.open(folder, os.O_RDONLY)
    with socket.socket(socket.AF_UNIX) as daemon:
        daemon.bind(f"/proc/self/fd/{handle}/{SOCKET_NAME}")
        os.close(handle)
        daemon.listen()

        def serve() -> None:
            for _ in range(5):
                client, _address = daemon.accept()
                client.recv(4096)
                client.sendall(answer + b"\n")
                client.close()

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        say: list[str] = []
        for asks in (
            lambda: pairing.cookie(folder),
            lambda: pairing.is_open(folder, "http://x/pair#abc"),
            lambda: pair.make_code(folder, "driver", say.append),
            lambda: pair.show_devices(folder, say.append),
            lambda: pair.revoke(folder, "abc", say.append),
        ):
            reason = "too many are paired" if b"error" in answer else "an answer that is none"
            with pytest.raises(UserError, match=reason):
                asks()
        thread.join(20)
        assert not say


def test_only_its_user_may_open_the_door(door: Any, folder: Path) -> None:
    assert (folder / SOCKET_NAME).stat().st_mode & 0o777 == 0o600
    assert folder.stat().st_mode & 0o777 == 0o700


def test_without_a_daemon_it_says_so(tmp_path: Path) -> None:
    with pytest.raises(NotRunning, match="no gazechair run answers at"):
        ask(tmp_path, {"ask": "list"})
    with pytest.raises(NotRunning):
        ask(tmp_path / "nowhere", {"ask": "list"})


def test_a_folder_in_the_sockets_place_is_set_aside(again: Any, folder: Path) -> None:
    desk = again(folder)
    (folder / SOCKET_NAME).mkdir()
    (folder / SOCKET_NAME / "something").touch()
    door = LocalDoor(desk, folder, lambda: URL)
    door.start()
    assert ask(folder, {"ask": "list"}) == {"devices": [], "problem": ""}
    door.stop()
    assert [one.name for one in folder.glob("*.damaged/*")] == ["something"]


def test_a_file_in_the_place_of_the_state_folder_is_named(tmp_path: Path, again: Any) -> None:
    (tmp_path / "state").write_text("something")
    with pytest.raises(StoreError, match=r"state is no folder; move it away"):
        again(tmp_path / "state")


def test_a_socket_left_by_a_killed_daemon_is_replaced(again: Any, folder: Path) -> None:
    desk = again(folder)
    handle = os.open(folder, os.O_RDONLY)
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(f"/proc/self/fd/{handle}/{SOCKET_NAME}")
    os.close(handle)
    door = LocalDoor(desk, folder, lambda: URL)
    door.start()
    assert ask(folder, {"ask": "list"}) == {"devices": [], "problem": ""}
    door.stop()
    assert not (folder / SOCKET_NAME).exists()


def test_a_socket_that_was_removed_with_its_folder_is_made_again(
    door: Any, folder: Path, tmp_path: Path
) -> None:
    folder.rename(tmp_path / "gone")
    wait_until(lambda: (folder / SOCKET_NAME).exists())
    made = ask(folder, {"ask": "code", "role": "viewer"})
    assert isinstance(door.pair(made["code"], "phone", "192.0.2.1"), Paired)


def test_where_no_socket_could_be_made_there_is_one_when_it_can(
    again: Any, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    door = LocalDoor(again(folder), folder, lambda: URL)
    (folder / SOCKET_NAME).touch()  # of a daemon that was killed
    with monkeypatch.context() as patch:
        patch.setattr(os, "unlink", _read_only)
        door.start()
        with pytest.raises(NotRunning):
            ask(folder, {"ask": "list"})
    wait_until(lambda: (folder / SOCKET_NAME).is_socket())
    assert ask(folder, {"ask": "list"}) == {"devices": [], "problem": ""}
    door.stop()


def _read_only(*_: object) -> None:
    raise OSError(errno.EROFS, os.strerror(errno.EROFS))
