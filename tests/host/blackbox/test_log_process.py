"""The log's process: all records arrive; it may stop, hang or be killed, and nobody waits."""

from __future__ import annotations

import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gazechair.base.child_process import END
from gazechair.base.child_records import RecordWriter
from gazechair.base.health import HealthRegistry
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status
from gazechair.blackbox import child, service
from gazechair.blackbox.reader import LogFile
from gazechair.blackbox.ring import Ring
from gazechair.blackbox.service import BlackBox
from gazechair.blackbox.writer import files
from gazechair.config.settings import LogConfig
from gazechair.picture.camera import Frame
from gazelink import messages
from patience import wait_until

FRAME = bytearray(messages.COMMAND.size)
FRAME[messages.TYPE_AT] = messages.COMMAND.type_id
JPEG = b"\xff\xd8tiny\xff\xd9"  # of which nothing smaller can be made


@pytest.fixture
def parts() -> HealthRegistry:
    return HealthRegistry()


@pytest.fixture
def box(tmp_path: Path, parts: HealthRegistry) -> Iterator[BlackBox]:
    pictures: Latest[Frame] = Latest()
    pictures.put(Frame(JPEG, time.monotonic()))
    box = BlackBox(LogConfig(pictures=True), tmp_path, parts, pictures.entry)
    box.start()
    wait_until(lambda: parts.part("log").state == "ok")
    yield box
    box.stop()


def topics(folder: Path) -> list[str]:
    return [line.topic for path in files(folder) for line in LogFile(path).lines()]


def test_what_is_noted_is_in_the_file_and_the_end_loses_nothing(
    box: BlackBox, tmp_path: Path
) -> None:
    box.note("up", time.monotonic(), bytes(FRAME))
    logging.getLogger("gazechair.board.link").warning("it is %s", "odd")
    logging.getLogger("elsewhere").warning("not ours")
    logging.getLogger("gazechair.people.pairing.desk").warning("Anna's tablet: not ours either")
    box.scan("front", time.monotonic(), bytes(1440))
    for _ in range(400):
        box.note("up", time.monotonic(), bytes(FRAME))
    box.stop()
    box.note("up", time.monotonic(), bytes(FRAME))
    found = topics(tmp_path)
    assert found.count("/host/command") == 401
    assert {"/health", "/latency", "/rosout", "/scan/front", "/picture"} <= set(found)
    texts = [
        line.message.msg for line in LogFile(files(tmp_path)[0]).lines() if line.topic == "/rosout"
    ]
    assert "it is odd" in texts
    assert not [text for text in texts if "not ours" in text]
    assert all(LogFile(path).length_s() >= 0 for path in files(tmp_path))


def test_a_process_that_is_killed_is_started_again(
    box: BlackBox, tmp_path: Path, parts: HealthRegistry
) -> None:
    pid = box.pid
    assert pid
    box.note("up", time.monotonic(), bytes(FRAME))
    wait_until(lambda: "/host/command" in topics(tmp_path))
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: box.pid not in (None, pid))
    wait_until(lambda: parts.part("log").state == "ok")
    box.note("up", time.monotonic(), bytes(FRAME))
    wait_until(lambda: topics(tmp_path).count("/host/command") == 2)
    box.stop()
    assert len(files(tmp_path)) == 2


def test_a_stop_of_the_whole_service_is_recorded_to_its_end(box: BlackBox, tmp_path: Path) -> None:
    """As of systemd, which sends SIGTERM to all processes."""
    pid = box.pid
    assert pid
    os.kill(pid, signal.SIGTERM)
    time.sleep(0.3)
    assert box.pid == pid
    box.note("up", time.monotonic(), bytes(FRAME))
    box.stop()
    assert topics(tmp_path).count("/host/command") == 1


def test_a_process_that_hangs_is_told(box: BlackBox, tmp_path: Path, parts: HealthRegistry) -> None:
    """As with a hanging disk: records that do not fit are dropped and reported, others logged."""
    pid = box.pid
    assert pid
    os.kill(pid, signal.SIGSTOP)
    try:
        for _ in range(30_000):
            box.note("up", time.monotonic(), bytes(FRAME))
        wait_until(lambda: parts.part("log").reason == service.DROPPING)
        assert "were dropped" in parts.part("log").detail
    finally:
        os.kill(pid, signal.SIGCONT)
    wait_until(lambda: parts.part("log").state == "ok")
    assert box.pid == pid
    box.stop()
    assert 5000 <= topics(tmp_path).count("/host/command") < 30_000


@pytest.mark.parametrize(
    "status",
    [
        Status("lost", "log_lost", "starting it again"),
        Status("degraded", "log_full", "the disk is full"),
        Status("ok", "ok", ""),
    ],
    ids=lambda status: status.reason,
)
def test_dropped_records_hide_no_other_reason_and_end_in_what_the_process_told(
    tmp_path: Path, parts: HealthRegistry, status: Status
) -> None:
    box, health = BlackBox(LogConfig(), tmp_path, parts, lambda: None), parts.part("log")
    box._on_status(status)
    for _ in range(6000):  # more than are kept
        box._ring.put("up", 0.0, b"")
    box._look()
    assert health.reason == (service.DROPPING if status.state == "ok" else status.reason)
    box._look()
    assert (health.state, health.reason, health.now().detail) == tuple(vars(status).values())[:3]


def test_a_process_that_is_slow_to_read_gets_what_waits_at_the_end(
    box: BlackBox, tmp_path: Path
) -> None:
    pid = box.pid
    assert pid
    os.kill(pid, signal.SIGSTOP)
    try:
        for _ in range(4000):  # more than its line holds
            box.note("up", time.monotonic(), bytes(FRAME))
        ending = threading.Thread(target=box.stop, name="ending")
        ending.start()
        wait_until(lambda: not box._on)
        time.sleep(0.3)
    finally:
        os.kill(pid, signal.SIGCONT)
    ending.join()
    assert topics(tmp_path).count("/host/command") == 4000


def test_the_last_moments_of_a_killed_daemon_are_kept(tmp_path: Path) -> None:
    """The log's process lives until it has finished the file."""
    program = f"""
import time
from pathlib import Path
from gazechair.base.health import HealthRegistry
from gazechair.blackbox.service import BlackBox
from gazechair.blackbox.ring import Ring
from gazechair.config.settings import LogConfig
parts = HealthRegistry()
box = BlackBox(LogConfig(), Path({str(tmp_path)!r}), parts)
box.start()
while parts.part("log").state != "ok":
    time.sleep(0.01)
for _ in range(100):
    box.note("up", time.monotonic(), bytes.fromhex({FRAME.hex()!r}))
while len(box._ring):
    time.sleep(0.001)
print(box.pid, flush=True)
time.sleep(600)
"""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path))
    daemon = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, env=environment
    )
    try:
        assert daemon.stdout is not None
        log = int(daemon.stdout.readline())
    finally:
        daemon.kill()
        daemon.wait()
    wait_until(lambda: not Path(f"/proc/{log}").exists())
    assert topics(tmp_path).count("/host/command") == 100
    file = LogFile(files(tmp_path)[0])
    assert [*file.lines()]
    assert file.whole


def test_what_waits_is_written_though_nobody_hears_the_process_any_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The daemon ends while the process waits for the disk, and takes no more messages."""
    monkeypatch.setattr(child, "SYNC_S", 0.0)
    ends = signal.getsignal(END)
    ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    read_end, write_end = os.pipe()
    os.close(read_end)
    ring = Ring()
    for number in range(100):
        ring.put("up", time.monotonic() + number, bytes(FRAME))
    ring.hand_over(ours)
    ours.close()
    limits = {"max_bytes": 10_000_000, "keep_s": 1e6, "fd": its.detach()}
    try:
        child.run({"folder": str(tmp_path), **limits}, RecordWriter(write_end))
    finally:
        signal.signal(END, ends)
        os.close(write_end)
    assert topics(tmp_path).count("/host/command") == 100


def test_without_the_extra_health_says_what_to_install(
    tmp_path: Path, parts: HealthRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "find_spec", lambda _: None)
    box = BlackBox(LogConfig(), tmp_path, parts)
    box.start()
    box.note("up", 0.0, bytes(FRAME))
    box.stop()
    assert "pip install 'gazechair[log]'" in parts.part("log").detail
    assert not files(tmp_path)
