"""The stand-in for the host sends what the host sends."""

import contextlib
import http.client
import json
import socket

from controlrig import Rig
from fakehost import ARMED, WELCOME, FakeHost
from gazechair.people.pairing import Device
from gazechair.web.page_client import PageClient


class Socket:
    """Keeps what is sent."""

    def __init__(self):
        self.sent = []

    def send(self, text):
        self.sent.append(json.loads(text))


def test_its_welcome_and_its_state_have_the_hosts_keys():
    rig, socket = Rig(), Socket()
    device = Device("3fa2b1", "driver", "tablet", 0, 0, "")
    PageClient(socket, rig.control, device, False)._welcome({})
    assert socket.sent == [WELCOME]
    assert set(ARMED) <= set(rig.look())


def test_what_was_connected_to_a_host_never_reaches_the_next_at_its_address():
    with contextlib.ExitStack() as end:
        listener = end.enter_context(socket.create_server(("127.0.0.1", 0)))
        stays, new = (
            http.client.HTTPConnection(*listener.getsockname(), timeout=5) for _ in range(2)
        )
        first = FakeHost(listener)
        stays.request("GET", "/static/icon.svg")
        assert b"<svg" in stays.getresponse().read()
        first.stop()
        second = FakeHost(listener)
        end.callback(second.stop)
        second.replies["GET /me"] = 200, {"id": "3fa2b1"}
        new.request("GET", "/me")
        assert json.load(new.getresponse()) == {"id": "3fa2b1"}
        assert stays.sock.recv(1) == b""
