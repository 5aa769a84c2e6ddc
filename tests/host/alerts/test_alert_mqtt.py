"""MQTT for Home Assistant, with a real broker: discovery, state, heartbeat, the last will."""

from __future__ import annotations

import contextlib
import json
import queue
import re
import socket
import ssl
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from paho.mqtt import client as paho

import gazesetup
from gazechair.alerts import mqtt
from gazechair.alerts.mqtt import EXPIRES_S, HEARTBEAT_S, HOST_SILENT_S, Broker, discovery
from gazechair.alerts.sender import Sender
from gazechair.base.health import DEGRADED, OK, Health
from gazechair.config import configuration
from gazechair.service import doctor
from gazechair.service.doctor import Finding
from patience import PATIENCE_S, wait_until

QUIET = {"help": "OFF", "state": "ok", "last_alert": ""}
_PASSWORD = (  # "hush-hush", as mosquitto_passwd writes it
    "chair:$7$101$c2FsdHNhbHRzYWx0$r5K0+Y2UeuAkaftUacASB0zvwlIwv2"
    "XCbgDlWQLxQxnxjXKpjz9Mc5fAaHog4PLUGmwfhdFKvRcMM8/NZiY8eQ==\n"
)
CALL = {"help": "ON", "state": "help", "last_alert": "De bestuurder vraagt hulp"}


class Listener:
    """Stands for Home Assistant: receives every message."""

    def __init__(self, port: int) -> None:
        self.received: queue.Queue[tuple[str, str]] = queue.Queue()
        self.retained: dict[str, str] = {}
        self._client = paho.Client(paho.CallbackAPIVersion.VERSION2)
        self._client.username_pw_set("chair", "hush-hush")
        self._client.on_message = self._on_message
        self._client.connect("127.0.0.1", port)
        self._client.subscribe("#", 1)
        self._client.loop_start()

    def _on_message(self, _client: Any, _data: Any, message: Any) -> None:
        self.retained[message.topic] = message.payload.decode()
        self.received.put((message.topic, message.payload.decode()))

    def wait(self, topic: str, payload: str) -> None:
        wait_until(lambda: self.retained.get(topic) == payload)

    def close(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """A broker that requires a password."""
    try:
        program = gazesetup.ensure_mosquitto()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))
    folder: Path = tmp_path_factory.mktemp("broker")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    passwords = folder / "passwords"
    passwords.write_text(_PASSWORD)
    passwords.chmod(0o600)
    (folder / "conf").write_text(
        f"listener {port} 127.0.0.1\npassword_file {passwords}\nallow_anonymous false\nuser root\n"
    )
    process = subprocess.Popen(
        [program, "-c", folder / "conf"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        wait_until(lambda: _listens(port))
        yield port
    finally:
        process.terminate()
        process.wait(10)


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture
def listener(port: int) -> Iterator[Listener]:
    listener = Listener(port)
    yield listener
    listener.close()


def test_the_process_announces_tells_and_its_end_is_told_by_the_broker(
    port: int, listener: Listener
) -> None:
    health = Health("alerts")
    sender = Sender(health, lambda *_: None)
    sender.start()
    try:
        url = f"mqtt://chair:hush-hush@127.0.0.1:{port}"
        sender.update_broker(url, "thuis", QUIET)
        listener.wait("gazechair/thuis/availability", "online")
        listener.wait("gazechair/thuis/state", json.dumps(QUIET))
        for topic, entity in discovery("thuis", battery=False).items():
            listener.wait(topic, json.dumps(entity))
        sender.update_broker(url, "thuis", CALL)
        listener.wait("gazechair/thuis/state", json.dumps(CALL))
        wait_until(lambda: health.state == OK)
    finally:
        sender.stop()
    listener.wait("gazechair/thuis/availability", "offline")


def test_two_chairs_whose_computers_have_the_same_name_speak_for_themselves(
    port: int, listener: Listener, tmp_path: Path
) -> None:
    machines = [tmp_path / "one", tmp_path / "other"]
    for machine in machines:
        machine.write_text(f"{machine.name}\n")
    nodes = [mqtt.node("rolstoel-één", machine) for machine in machines]
    brokers = [Broker() for _ in nodes]
    received: list[str] = []
    try:
        for state in (QUIET, CALL, QUIET):  # the first one calls meanwhile
            for node, broker in zip(nodes, brokers, strict=True):
                message = CALL if broker is brokers[0] else state
                broker.update(f"mqtt://chair:hush-hush@127.0.0.1:{port}", node, message, 0.0)
                wait_until(lambda one=broker: one._connected)
                broker.tick(0.0)
                listener.wait(f"gazechair/{node}/state", json.dumps(message))
                received += [one.problem for one in brokers if one._client is not None]
        assert {*received} == {""}
        assert listener.retained[f"gazechair/{nodes[0]}/state"] == json.dumps(CALL)
        entities = [*discovery(nodes[0], True), *discovery(nodes[1], True)]
        assert len({*entities}) == 8
        # As its documentation has it: <discovery_prefix>/<component>/[<node_id>/]<object_id>/config
        pattern = r"homeassistant/[a-z_]+/[a-zA-Z0-9_-]+/[a-zA-Z0-9_-]+/config"
        assert all(re.fullmatch(pattern, topic) for topic in entities)
    finally:
        for broker in brokers:
            broker._client.disconnect()
            broker._client.loop_stop()


def test_an_offline_that_was_left_at_the_broker_does_not_hide_a_call(
    port: int, listener: Listener
) -> None:
    """A last will of a connection before, that the broker publishes late; or somebody's garbage."""
    broker, topic = Broker(), "gazechair/hal/availability"
    url = f"mqtt://chair:hush-hush@127.0.0.1:{port}"
    try:
        broker.update(url, "hal", QUIET, 0.0)
        wait_until(lambda: broker._connected)
        broker.tick(0.0)
        listener.wait(topic, "online")
        broker._client.publish(topic, "offline", qos=1, retain=True)
        listener.wait(topic, "offline")
        broker.update(url, "hal", CALL, 1.0)
        broker.tick(1.0)
        listener.wait(topic, "online")
    finally:
        broker._client.disconnect()
        broker._client.loop_stop()


def test_a_wrong_password_or_no_broker_is_a_reason_without_the_secret(port: int) -> None:
    for address in (f"chair:wrong-one@127.0.0.1:{port}", "chair:wrong-one@127.0.0.1:1"):
        health = Health("alerts")
        sender = Sender(health, lambda *_: None)
        sender.start()
        try:
            sender.update_broker(f"mqtt://{address}", "x", QUIET)
            wait_until(lambda part=health: part.state == DEGRADED and "yet" not in part.detail)
            assert health.detail.startswith("MQTT: ")
            assert "wrong-one" not in health.detail
        finally:
            sender.stop()


def found(tmp_path: Path, address: str) -> Finding:
    """What the doctor finds about this broker."""
    file = tmp_path / "chair.toml"
    file.write_text(f'[alerts]\nmqtt = "mqtt://{address}"\n')
    findings = doctor._alerts(configuration.load(file))
    (finding,) = (one for one in findings if one.what == "mqtt")
    return finding


def test_the_doctor_asks_the_broker_beside_a_host_that_runs(port: int, tmp_path: Path) -> None:
    broker = Broker()
    url = f"chair:hush-hush@127.0.0.1:{port}"
    broker.update(f"mqtt://{url}", "x", QUIET, 0.0)
    wait_until(lambda: broker._connected)
    assert found(tmp_path, url) == Finding(doctor.OK, "mqtt", "the broker answers")
    assert broker._connected
    broker._client.disconnect()
    broker._client.loop_stop()


def test_the_doctor_finds_a_broker_that_refuses_is_not_there_or_has_no_package(
    port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = found(tmp_path, f"chair:wrong-one@127.0.0.1:{port}")
    gone = found(tmp_path, "chair:wrong-one@127.0.0.1:1")
    monkeypatch.setattr(mqtt, "find_spec", lambda _: None)
    missing = found(tmp_path, "host")
    assert [one.level for one in (refused, gone, missing)] == [doctor.FAIL] * 3
    assert refused.found == "Not authorized"
    assert gone.found == "the broker does not answer: Connection refused"
    assert (missing.found, missing.do) == (mqtt.MISSING, "")
    assert "wrong-one" not in str((refused, gone))


@contextlib.contextmanager
def serving(meet: Callable[[socket.socket], object]) -> Iterator[int]:
    """A server that does `meet` with each connection, and then closes it; its port."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            while True:
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                with connection, contextlib.suppress(OSError):
                    meet(connection)

        threading.Thread(target=serve, daemon=True).start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def encrypted(tmp_path: Path) -> Iterator[str]:
    """The address of a broker with a certificate that nobody signed."""
    words = ["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    files = ["-subj", "/CN=localhost", "-keyout", "key", "-out", "crt"]
    subprocess.run(["openssl", *words, *files], cwd=tmp_path, check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(tmp_path / "crt", tmp_path / "key")

    def meet(connection: socket.socket) -> None:
        context.wrap_socket(connection, server_side=True).close()

    with serving(meet) as port:
        yield f"mqtts://chair:hush-hush@localhost:{port}"


UNTRUSTED = "certificate verify failed: self-signed certificate"


def test_the_doctor_tells_a_certificate_that_is_not_trusted(encrypted: str) -> None:
    assert mqtt.try_broker(encrypted).replace("self signed", "self-signed") == UNTRUSTED


def test_the_host_tells_a_certificate_that_is_not_trusted(encrypted: str) -> None:
    broker = Broker()
    broker.update(encrypted, "x", QUIET, 0.0)
    wait_until(lambda: broker.problem.replace("self signed", "self-signed") == UNTRUSTED)
    broker._client.disconnect()
    broker._client.loop_stop()


def test_a_broker_that_closes_before_it_answers_is_told_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt, "_ANSWER_S", PATIENCE_S)
    with serving(lambda connection: connection.recv(1000)) as port:
        began_s = time.monotonic()
        problem = mqtt.try_broker(f"mqtt://chair:hush-hush@127.0.0.1:{port}")
        assert time.monotonic() - began_s < PATIENCE_S / 2
    assert problem == "the broker does not answer: The connection was lost."


def test_the_host_tells_a_broker_that_closes_before_it_answers() -> None:
    broker = Broker()
    with serving(lambda connection: connection.recv(1000)) as port:
        broker.update(f"mqtt://127.0.0.1:{port}", "x", QUIET, 0.0)
        wait_until(lambda: broker.problem.startswith("the broker is gone"))
    broker._client.disconnect()
    broker._client.loop_stop()


class Paper:
    """A client that only records."""

    def __init__(self) -> None:
        self.message: list[tuple[str, str]] = []

    def publish(self, topic: str, payload: str, qos: int = 0, retain: bool = False) -> None:
        assert qos == 1
        assert retain == (not topic.endswith("/state"))
        self.message.append((topic.rpartition("/")[2], payload))

    def take(self) -> list[tuple[str, str]]:
        message, self.message = self.message, []
        return [(topic, payload) for topic, payload in message if topic != "config"]


def test_a_heartbeat_each_half_minute_while_the_host_lives() -> None:
    broker, paper = Broker(), Paper()
    broker._client = paper
    broker.update("", "", QUIET, 100.0)
    broker.tick(100.0)
    assert paper.message == []
    broker._connected = True
    broker.tick(100.0)
    online, state = ("availability", "online"), ("state", json.dumps(QUIET))
    assert paper.take() == [online, state]
    for now_s in range(101, 100 + 2 * int(HEARTBEAT_S) + 1):
        broker.update("", "", QUIET, now_s)
        broker.tick(now_s)
    assert paper.take() == [online, state, online, state]
    broker.update("", "", CALL, 161.0)
    broker.tick(161.0)
    assert paper.take() == [online, ("state", json.dumps(CALL))]
    for now_s in range(162, 300):
        broker.tick(now_s)  # the host hangs
    assert paper.take() == [("availability", "offline")]
    broker.update("", "", CALL, 300.0)
    broker.tick(300.0)
    assert paper.take() == [online, ("state", json.dumps(CALL))]
    assert HOST_SILENT_S < HEARTBEAT_S < EXPIRES_S / 2


def test_without_the_package_the_reason_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt, "find_spec", lambda _: None)
    broker = Broker()
    broker.update("mqtt://x", "x", QUIET, 0.0)
    broker.tick(0.0)
    assert broker.problem == mqtt.MISSING


@pytest.mark.parametrize("rest", ["chair:hu[sh@host", "chair:hush", "chair:hush\uff0fhush@host"])
def test_an_address_that_does_not_split_is_a_problem_without_its_password(rest: str) -> None:
    broker = Broker()
    broker.update(f"mqtt://{rest}", "x", QUIET, 0.0)
    broker.tick(0.0)
    assert broker.problem == mqtt.NO_ADDRESS


def test_every_entity_expires_by_itself_and_is_of_one_device() -> None:
    entities = discovery("thuis", battery=True).values()
    assert len({entity["unique_id"] for entity in entities}) == len(entities) == 4
    for entity in entities:
        assert entity["expire_after"] == EXPIRES_S
        assert entity["availability_topic"] == "gazechair/thuis/availability"
        assert entity["device"]["identifiers"] == ["gazechair_thuis"]
