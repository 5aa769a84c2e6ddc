"""Publishes help wanted, state, last alert and a heartbeat over MQTT for Home Assistant.

One thread calls everything here, except paho's callbacks, which only record what happened.
"""

from __future__ import annotations

import hashlib
import json
import platform
import re
import ssl
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from gazechair.alerts.reasons import KINDS

MISSING = "no broker is told: pip install 'gazechair[alerts]'"
NO_ADDRESS = "alerts.mqtt is no address of a broker"
HEARTBEAT_S = 30.0
EXPIRES_S = 90  # Home Assistant calls the chair unavailable then
HOST_SILENT_S = 15.0  # a host that is silent for longer counts as dead
_MACHINE = Path("/etc/machine-id")
_KEEPALIVE_S = 20
_ANSWER_S = 5.0
_NOT_YET = "not connected yet"
_MOST_QUEUED = 100  # for a broker that accepts a connection and then never answers
OK = "ok"
BATTERY = "battery"  # of the state; a computer without one leaves it out


class Broker:
    """One connection, re-established whenever it is lost."""

    def __init__(self) -> None:
        self.problem = ""
        """Why the broker gets no state; "" while it does, or if none is configured."""
        self._client: Any = None
        self._connected = False
        self._announced = False
        self._online = False
        self._node = ""
        self._state: dict[str, str] = {}
        self._updated_s = 0.0
        self._sent_s = 0.0

    def update(self, url: str, node: str, state: dict[str, str], now_s: float) -> None:
        """Set the host's state; also its sign of life."""
        self._updated_s = now_s
        if self._client is None:
            self._node = node
            self._connect(url)
        if state != self._state:
            self._state = state
            self._sent_s = 0.0

    def tick(self, now_s: float) -> None:
        """Call regularly: announces after connecting, sends a heartbeat every HEARTBEAT_S."""
        if not self._connected or not self._state:
            self._announced = False
            return
        if not self._announced:
            self._announced, self._online, self._sent_s = True, False, 0.0
            for topic, entity in discovery(self._node, BATTERY in self._state).items():
                self._client.publish(topic, json.dumps(entity), qos=1, retain=True)
        online = now_s - self._updated_s < HOST_SILENT_S
        due = online and (not self._sent_s or now_s - self._sent_s >= HEARTBEAT_S)
        # With each state: another client's value, or a late last will, would stay for ever.
        if online != self._online or due:
            self._online = online
            word = "online" if online else "offline"
            self._client.publish(_topic(self._node, "availability"), word, qos=1, retain=True)
        if due:
            self._sent_s = now_s
            self._client.publish(_topic(self._node, "state"), json.dumps(self._state), qos=1)

    def _connect(self, url: str) -> None:
        if find_spec("paho") is None:
            self.problem = MISSING
            return
        from paho.mqtt import client as paho
        from paho.mqtt.enums import CallbackAPIVersion

        client = paho.Client(CallbackAPIVersion.VERSION2, client_id=f"gazechair-{self._node}")
        client.will_set(_topic(self._node, "availability"), "offline", qos=1, retain=True)
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_connect_fail = self._on_connect_fail
        client.reconnect_delay_set(1, 30)
        client.max_queued_messages_set(_MOST_QUEUED)
        self._client = client
        self.problem = _NOT_YET
        try:
            client.connect_async(*_target(client, url), _KEEPALIVE_S)
        except ValueError:  # its text may contain the password
            self.problem = NO_ADDRESS
            return
        client.loop_start()

    def _on_connect(self, _client: Any, _data: Any, _flags: Any, reason: Any, _more: Any) -> None:
        self.problem = str(reason) if reason.is_failure else ""
        self._connected = not reason.is_failure

    def _on_disconnect(
        self, _client: Any, _data: Any, _flags: Any, reason: Any, _more: Any
    ) -> None:
        self._connected = False
        if self.problem in ("", _NOT_YET):  # else the broker has refused the connection
            self.problem = f"the broker is gone: {reason}"

    def _on_connect_fail(self, _client: Any, _data: Any) -> None:
        self._connected = False
        self.problem = _unanswered(sys.exc_info()[1])  # paho calls this while handling it


def _unanswered(why: object) -> str:
    """One line for people: why there is no connection. It contains no password."""
    if isinstance(why, ssl.SSLCertVerificationError):
        return f"certificate verify failed: {why.verify_message}"
    if isinstance(why, OSError):
        why = why.strerror or why
    return f"the broker does not answer: {why}" if why else "the broker does not answer"


def _target(client: Any, url: str) -> tuple[str, int]:
    """The broker's host and port; the client gets the password. Raises ValueError."""
    where = urlsplit(url)
    if where.username:
        client.username_pw_set(unquote(where.username), unquote(where.password or ""))
    if where.scheme == "mqtts":
        client.tls_set()
    return where.hostname or "", where.port or (8883 if where.scheme == "mqtts" else 1883)


def try_broker(url: str) -> str:
    """Connect once, beside a host that runs; why the broker refuses, "" when it does not."""
    if find_spec("paho") is None:
        return MISSING
    from paho.mqtt import client as paho
    from paho.mqtt.enums import CallbackAPIVersion

    client: Any = paho.Client(CallbackAPIVersion.VERSION2)  # with an id of its own
    answers: list[str] = []

    def on_connect(_client: Any, _data: Any, _flags: Any, reason: Any, _more: Any) -> None:
        answers.append(str(reason) if reason.is_failure else "")

    client.on_connect = on_connect
    try:
        client.connect(*_target(client, url), _KEEPALIVE_S)
        end_s, ended = time.monotonic() + _ANSWER_S, 0
        while not (answers or ended) and time.monotonic() < end_s:
            ended = client.loop(0.1)
    except OSError as error:  # first: an untrusted certificate is a ValueError, too
        return _unanswered(error)
    except ValueError:
        return NO_ADDRESS
    client.disconnect()
    return answers[0] if answers else _unanswered(ended and paho.error_string(ended))


def node(name: str = "", machine: Path = _MACHINE) -> str:
    """The chair's name at the broker: the computer's, "": this one's, and eight characters.

    With these, chairs whose computers have the same name do not mix their states. Each letter
    may be in a topic of Home Assistant's discovery.
    """
    try:
        identity = machine.read_text().strip()
    except (OSError, ValueError):
        identity = ""
    # machine-id(5): nobody else may learn it.
    own = hashlib.sha256(f"gazechair {identity}".encode()).hexdigest()[:8] if identity else ""
    readable = re.sub(r"\W", "_", name or platform.node(), flags=re.ASCII)
    return "_".join(filter(None, (readable, own))) or "chair"


def _topic(node: str, what: str) -> str:
    return f"gazechair/{node}/{what}"


def discovery(node: str, battery: bool) -> dict[str, dict[str, Any]]:
    """Home Assistant's discovery messages: {topic: entity}; `battery`: the computer has one."""
    device = {
        "identifiers": [f"gazechair_{node}"],
        "name": f"gazechair {node}",
        "model": "gazechair",
    }
    found = {}
    entities: list[tuple[str, str, str, dict[str, Any]]] = [
        ("binary_sensor", "help", "Help wanted", {"device_class": "problem"}),
        ("sensor", "state", "State", {"device_class": "enum", "options": [OK, *KINDS[:-1]]}),
        ("sensor", "last_alert", "Last alert", {}),
    ]
    if battery:
        more = {"device_class": "battery", "unit_of_measurement": "%"}
        entities.append(("sensor", BATTERY, "Battery of the computer", more))
    for kind, what, name, more in entities:
        found[f"homeassistant/{kind}/gazechair_{node}/{what}/config"] = {
            "name": name,
            "unique_id": f"gazechair_{node}_{what}",
            "state_topic": _topic(node, "state"),
            "value_template": "{{ value_json." + what + " }}",
            "availability_topic": _topic(node, "availability"),
            "expire_after": EXPIRES_S,
            "device": device,
            **more,
        }
    return found
