"""Watched child processes: records through the pipe, and restarts."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.base import supervisor
from gazechair.base.child_process import end, would_run
from gazechair.base.child_records import DATA, MAX_RECORD, STATUS, RecordReader, RecordWriter
from gazechair.base.supervisor import Status, Supervisor

LONG_S = 60.0


@settings(deadline=None)
@given(st.lists(st.binary(max_size=300), max_size=10), st.integers(1, 50))
def test_records_come_out_however_the_pipe_cuts_them(payloads: list[bytes], size: int) -> None:
    read_fd, write_fd = os.pipe()
    writer = RecordWriter(write_fd)
    for payload in payloads:
        writer.data(payload)
    os.close(write_fd)
    reader = RecordReader()
    found = []
    while piece := os.read(read_fd, size):
        found += reader.feed(piece)
    os.close(read_fd)
    assert found == [(DATA, payload) for payload in payloads]


@pytest.mark.parametrize("length", [0, MAX_RECORD + 1, 0xFFFFFFFF])
def test_a_length_out_of_range_is_refused(length: int) -> None:
    with pytest.raises(ValueError, match="record of"):
        RecordReader().feed(struct.pack("<I", length))


def test_a_status_is_a_record_of_its_own() -> None:
    read_fd, write_fd = os.pipe()
    RecordWriter(write_fd).status("lost", "lidar_lost", "why")
    ((kind, payload),) = RecordReader().feed(os.read(read_fd, 1000))
    os.close(read_fd)
    os.close(write_fd)
    assert kind == STATUS
    assert payload == b'{"state": "lost", "reason": "lidar_lost", "detail": "why"}'


CHILD = """
import sys, time
from gazechair.base.child_main import enter_child
out = enter_child()
print("a library that prints")
{body}
"""


class Watched:
    def __init__(self, folder: Path, body: str, **limits: Any) -> None:
        (folder / "some_child.py").write_text(CHILD.format(body=body))
        self.data: list[bytes] = []
        self.statuses: list[Status] = []
        self.supervisor = Supervisor(
            "some_child",
            "argument",
            self.data.append,
            self.statuses.append,
            lost_reason="part_lost",
            **limits,
        )
        self.supervisor.start()

    def wait(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + LONG_S
        while not condition():
            assert time.monotonic() < deadline_s, self.statuses
            time.sleep(0.01)


@pytest.fixture
def watch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Watched]]:
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    made: list[Watched] = []

    def make(body: str, **limits: Any) -> Watched:
        made.append(Watched(tmp_path, body, **limits))
        return made[-1]

    yield make
    for watched in made:
        watched.supervisor.stop()


HEARING = """
import threading
heard = []
def hear():
    for line in sys.stdin.buffer:
        heard[:] = [line]
threading.Thread(target=hear, daemon=True).start()
while True:
    out.data(b"".join(heard))
    time.sleep(0.02)
"""


def test_a_child_that_listens_is_told_the_newest_word_and_so_is_its_successor(
    watch: Callable[..., Watched],
) -> None:
    child = watch(HEARING, listens=True)
    child.supervisor.send(b"one")
    child.wait(lambda: child.data[-1:] == [b"one\n"])
    child.supervisor.send(b"two")
    child.wait(lambda: child.data[-1] == b"two\n")
    pid = child.supervisor.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    child.wait(lambda: child.supervisor.restarts == 1)
    child.data.clear()
    child.wait(lambda: child.data[-1:] == [b"two\n"])


def test_nobody_waits_for_a_child_that_does_not_listen_and_nothing_piles_up(
    watch: Callable[..., Watched],
) -> None:
    deaf = watch("while True: out.data(b'value'); time.sleep(0.001)", listens=True)
    deaf.wait(lambda: len(deaf.data) > 3)
    for number in range(300):  # 900 kB, the pipe holds 64
        deaf.supervisor.send(b"%03d" % number * 1000)
        received = len(deaf.data)
        deaf.wait(lambda received=received: len(deaf.data) > received)
    assert deaf.supervisor.restarts == 0


def test_values_and_statuses_arrive_and_its_argument_is_passed(
    watch: Callable[..., Watched],
) -> None:
    child = watch("out.status('ok', 'ok', sys.argv[1]); out.data(b'value'); time.sleep(99)")
    child.wait(lambda: child.data == [b"value"])
    assert child.statuses == [Status("ok", "ok", "argument")]


def test_a_burst_is_reduced_to_the_newest(watch: Callable[..., Watched]) -> None:
    child = watch("[out.data(b'%d' % n) for n in range(5000)]; time.sleep(99)")
    child.wait(lambda: bool(child.data) and child.data[-1] == b"4999")
    assert len(child.data) < 5000


def test_a_child_that_ends_is_said_and_started_again(watch: Callable[..., Watched]) -> None:
    child = watch("out.data(b'x')")
    child.wait(lambda: len(child.data) >= 2)
    assert child.supervisor.restarts >= 1
    assert child.statuses[0].state == "lost"
    assert child.statuses[0].reason == "part_lost"


def test_whatever_a_child_says_another_one_is_started(watch: Callable[..., Watched]) -> None:
    """The parent's own code may not be ready for it."""

    def surprised(_facts: bytes) -> None:
        raise KeyError("number")

    child = watch("out.facts(b'{}'); time.sleep(99)", on_facts=surprised)
    child.wait(lambda: child.supervisor.restarts >= 1)
    assert child.statuses[0].how == "wrong"


def test_one_that_waits_for_a_processor_or_a_disk_is_given_time(
    watch: Callable[..., Watched], monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[int] = []

    def runs(pid: int) -> bool:
        looks.append(pid)
        return len(looks) < 5

    monkeypatch.setattr(supervisor, "would_run", runs)
    child = watch("out.data(b'x'); time.sleep(99)", silent_s=0.2, patience_s=LONG_S)
    child.wait(lambda: child.supervisor.restarts >= 1)
    assert len(looks) >= 5
    assert child.statuses[0].how == "hangs"


def test_what_a_process_waits_for() -> None:
    assert would_run(os.getpid())  # this thread runs
    sleeps = subprocess.Popen(
        [sys.executable, "-c", "print(flush=True); input()"], stdin=-1, stdout=-1
    )
    try:
        assert sleeps.stdout is not None
        sleeps.stdout.readline()
        end_s = time.monotonic() + LONG_S
        while would_run(sleeps.pid):
            assert time.monotonic() < end_s
    finally:
        sleeps.kill()
        sleeps.communicate()
    assert not would_run(sleeps.pid)


def test_its_own_explanation_is_not_talked_over(watch: Callable[..., Watched]) -> None:
    child = watch("out.status('lost', 'own_reason', 'why'); sys.exit(1)")
    child.wait(lambda: len(child.statuses) >= 2)
    assert {status.reason for status in child.statuses} == {"own_reason"}


def test_a_child_that_never_delivers_is_killed(watch: Callable[..., Watched]) -> None:
    child = watch("time.sleep(99)", start_s=0.5)
    child.wait(lambda: child.supervisor.restarts >= 1)
    assert "hangs" in child.statuses[0].detail


def test_a_child_that_starts_too_slowly_is_given_more_time(watch: Callable[..., Watched]) -> None:
    slow = watch("time.sleep(0.8)\nout.data(b'there')\ntime.sleep(60)", start_s=0.5)
    slow.wait(lambda: slow.data == [b"there"])
    assert 1 <= slow.supervisor.restarts <= 4


def test_a_part_that_never_works_is_disabled_and_tried_at_long_intervals(
    watch: Callable[..., Watched], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("gazechair.base.supervisor._GIVEN_UP", 3)
    child = watch("sys.exit(1)", longest_pause_s=0.01)
    child.wait(lambda: (child.supervisor.next_start_s or 0.0) > time.monotonic() + 50.0)
    assert child.supervisor.restarts == 2
    assert [line for line in caplog.messages if "disabled" in line] == [
        "some_child is disabled: it has never worked"
    ]


def test_a_part_that_has_worked_is_never_given_up(
    watch: Callable[..., Watched], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("gazechair.base.supervisor._GIVEN_UP", 2)
    once = f"from pathlib import Path; seen = Path({str(tmp_path / 'seen')!r})"
    child = watch(
        f"{once}\nif not seen.exists():\n    seen.touch(); out.data(b'x')", longest_pause_s=0.01
    )
    child.wait(lambda: child.supervisor.restarts >= 4)
    assert child.data == [b"x"]


def test_a_child_that_falls_silent_is_killed(watch: Callable[..., Watched]) -> None:
    child = watch("out.data(b'x'); time.sleep(99)", silent_s=0.3)
    child.wait(lambda: len(child.data) >= 2)
    assert "hangs" in child.statuses[0].detail


def test_nonsense_on_the_pipe_ends_the_child(watch: Callable[..., Watched]) -> None:
    child = watch("import os; os.write(out._fd, b'\\xff' * 100); time.sleep(99)")
    child.wait(lambda: child.supervisor.restarts >= 1)
    assert "nonsense" in child.statuses[0].detail


def test_a_stop_of_the_whole_service_leaves_its_children_to_the_daemon(
    watch: Callable[..., Watched],
) -> None:
    """As of systemd, which sends SIGTERM to all processes."""
    child = watch("while True: out.data(b'x'); time.sleep(0.01)")
    child.wait(lambda: child.data != [])
    pid = child.supervisor.pid
    assert pid is not None
    os.kill(pid, signal.SIGTERM)
    so_far = len(child.data)
    child.wait(lambda: len(child.data) >= so_far + 20)
    assert child.supervisor.pid == pid
    child.supervisor.stop()
    assert child.statuses == []


def test_stop_ends_a_child_that_ignores_the_request(watch: Callable[..., Watched]) -> None:
    child = watch(
        "import signal; signal.signal(signal.SIGUSR1, signal.SIG_IGN); out.data(b'x')\n"
        "while True: time.sleep(1)"
    )
    child.wait(lambda: child.data == [b"x"])
    pid = child.supervisor.pid
    assert pid is not None
    child.supervisor.stop()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


class InTheKernel(subprocess.Popen[bytes]):
    """Waits for a device that never answers: no signal ends it before it wakes."""

    def send_signal(self, sig: int) -> None:
        pass

    def wait(self, timeout: float | None = None) -> int:
        assert timeout is not None
        raise subprocess.TimeoutExpired(self.args, timeout)


def test_a_child_stuck_in_the_kernel_holds_up_nobody() -> None:
    process = InTheKernel([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        end(process)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        os.waitpid(process.pid, 0)
