"""Attacks from the network, each as its own program.

`python -m gazemeasure.page.flooding NAME PORT COOKIE_NAME COOKIE`. It ends after a minute, or when
its standard input is closed. It runs at the lowest priority, because an attacker has their own
processor.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from gazemeasure.page import hostile
from gazemeasure.page.raw_page import frame, upgrade

_LONGEST_S = 60.0
_THREADS = 4
_OPEN = 200
_LIMIT_S = 2.0
_TEXT, _PING = 1, 9


class Attack:
    """What the attacks need to know about the host."""

    def __init__(self, port: int, cookie_name: str, cookie: str) -> None:
        self.port = port
        self.cookie_name = cookie_name
        self.cookie = cookie

    def ask(self, data: bytes) -> None:
        """Send one request, and read its answer to the end."""
        with contextlib.suppress(OSError), self.line() as line:
            line.sendall(data)
            while line.recv(65536):
                pass

    def line(self) -> socket.socket:
        """Open a connection."""
        return socket.create_connection(("127.0.0.1", self.port), _LIMIT_S)

    def socket(self, path: str = "/ws/control") -> socket.socket:
        """Open a paired WebSocket."""
        return upgrade(self.port, path, self.cookie)


def _requests(attack: Attack, headers: Iterator[tuple[str, str]]) -> Iterator[None]:
    everything = [hostile.request("/pair", header + "\r\n") for _, header in headers]
    for data in itertools.cycle(everything):
        attack.ask(data)
        yield


def _backslashes(attack: Attack) -> Iterator[None]:
    only = [next(hostile.cookies(attack.cookie_name))]
    return _requests(attack, iter(only))


def _addresses(attack: Attack) -> Iterator[None]:
    for _, target in itertools.cycle(list(hostile.targets("/pair"))):
        attack.ask(hostile.request(target))
        yield


def _bodies(attack: Attack) -> Iterator[None]:
    for _, header, body in itertools.cycle(list(hostile.bodies())):
        attack.ask(hostile.request("/pair", header, body, "POST"))
        yield


def _codes(attack: Attack) -> Iterator[None]:
    kind = "Content-Type: application/json\r\n"
    for guess in itertools.count():
        attack.ask(hostile.request("/pair", kind, b'{"code":"2222%04d"}' % (guess % 9999), "POST"))
        yield


def _handshakes(attack: Attack) -> Iterator[None]:
    while True:
        attack.ask(hostile.request("/ws/control", hostile.UPGRADE))
        yield


def _hellos(attack: Attack) -> Iterator[None]:
    hello = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(507)
    while True:
        attack.ask(hello)
        yield


def _open_and_close(attack: Attack) -> Iterator[None]:
    while True:
        with contextlib.suppress(OSError):
            attack.line().close()
        yield


def _stay_open(attack: Attack, begin: bytes, each: bytes = b"") -> Iterator[None]:
    lines: list[socket.socket] = []
    while True:
        if len(lines) >= _OPEN // _THREADS:
            lines.pop(0).close()
        with contextlib.suppress(OSError):
            lines.append(attack.line())
            lines[-1].sendall(begin)
        for line in lines if each else []:
            with contextlib.suppress(OSError):
                line.send(each)
        yield


def _frames(attack: Attack, path: str, first: bytes, each: bytes, per_s: float) -> Iterator[None]:
    """Send frames on a paired socket that is reopened whenever it is cut."""
    while True:
        with contextlib.suppress(OSError), attack.socket(path) as line:
            line.sendall(first)
            while True:
                line.sendall(each * 10)
                time.sleep(10 / per_s)
                yield
        yield


def _downloads(attack: Attack) -> Iterator[None]:
    while True:
        attack.ask(hostile.request("/static/caretaker.js", f"Cookie: {attack.cookie}\r\n"))
        yield


_BEAT = frame(_TEXT, b'{"k":"hb","token":1}')
_MORE = frame(0, last=False)
_HALF = b"GET /pair HTTP/1.1\r\nHost: 127.0.0.1\r\nX: "
ATTACKS: dict[str, Callable[[Attack], Iterator[None]]] = {
    "cookies of backslashes": _backslashes,
    "every cookie": lambda a: _requests(a, hostile.cookies(a.cookie_name)),
    "every header": lambda a: _requests(a, hostile.headers()),
    "every address": _addresses,
    "every body": _bodies,
    "wrong codes": _codes,
    "unpaired WebSockets": _handshakes,
    "TLS on a plain port": _hellos,
    "connections, closed at once": _open_and_close,
    "idle connections": lambda a: _stay_open(a, b""),
    "half requests": lambda a: _stay_open(a, _HALF),
    "requests byte by byte": lambda a: _stay_open(a, _HALF, b"x"),
    "viewer: pings, 900 a second": lambda a: _frames(a, "/ws/control", b"", frame(_PING), 900),
    "viewer: pings without end": lambda a: _frames(a, "/ws/control", b"", frame(_PING), 1e5),
    "viewer: empty fragments": lambda a: _frames(
        a, "/ws/control", frame(_TEXT, last=False), _MORE, 1e5
    ),
    "viewer: messages, 900 a second": lambda a: _frames(a, "/ws/control", b"", _BEAT, 900),
    "viewer: messages without end": lambda a: _frames(a, "/ws/control", b"", _BEAT, 1e5),
    "viewer: pictures": lambda a: _frames(a, "/ws/video", b"", frame(_PING), 900),
    "viewer: downloads": _downloads,
}


def _run(words: list[str]) -> None:
    name, port, cookie_name, cookie = words
    os.nice(19)
    attack = Attack(int(port), cookie_name, cookie)
    done = [0] * _THREADS
    end_s = time.monotonic() + _LONGEST_S

    def work(mine: int) -> None:
        for _ in ATTACKS[name](attack):
            done[mine] += 1
            if time.monotonic() > end_s:
                return

    for mine in range(_THREADS):
        threading.Thread(target=work, args=(mine,), name=f"attack-{mine}", daemon=True).start()
    reader: Any = sys.stdin
    reader.read()
    print(sum(done), flush=True)


if __name__ == "__main__":
    _run(sys.argv[1:])
