"""The stand-in for the host sends what the host sends."""

import json

from controlrig import Rig
from fakehost import ARMED, WELCOME
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
