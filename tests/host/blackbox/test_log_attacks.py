"""The log under attack: folders in the place of files, deletions, records that no file takes."""

from __future__ import annotations

import json
import marshal
import shutil
from pathlib import Path
from typing import Any

import pytest

from gazechair.blackbox.child import SYNC_S, Keeper
from gazechair.blackbox.reader import LogFile
from gazechair.blackbox.writer import LogWriter, files


class Out:
    """Records the messages of the log's process to the daemon."""

    def __init__(self) -> None:
        self.figures: list[dict[str, Any]] = []
        self.states: list[str] = []

    def data(self, payload: bytes) -> None:
        self.figures.append(json.loads(payload))

    def status(self, state: str, *_: str) -> None:
        self.states.append(state)


class Log:
    """The log's code without a process; the test sets the time."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self.now_s = 100.0
        monkeypatch.setattr("gazechair.blackbox.child.time.monotonic", lambda: self.now_s)
        self.out = Out()
        self.writer = LogWriter(folder, 10**8, 1e9, free_bytes=lambda _: 10**10)
        self.keeper = Keeper(self.writer, self.out)  # type: ignore[arg-type]

    def second(self, *records: tuple[Any, ...]) -> None:
        self.keeper.take(marshal.dumps(list(records) or [line("text")]))
        self.now_s += SYNC_S
        self.keeper.due()

    def lines(self) -> list[str]:
        self.writer.close()
        found = (one for path in files(self.folder) for one in LogFile(path).lines())
        return [one.message.msg for one in found if one.topic == "/rosout"]


def line(text: str) -> tuple[Any, ...]:
    return "line", 10**9, (20, "gazechair", text)


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Log:
    return Log(tmp_path / "log", monkeypatch)


def test_a_file_in_the_place_of_the_folder_is_set_aside(log: Log) -> None:
    log.folder.write_text("somebody's")
    log.second()
    assert log.lines() == ["text"]
    assert log.folder.with_suffix(".damaged").read_text() == "somebody's"
    assert log.out.states == ["ok"]


def test_a_folder_that_is_named_as_a_file_is_left_alone(log: Log) -> None:
    (log.folder / "000001_x.mcap" / "deep").mkdir(parents=True)
    log.writer._max_bytes = 1  # everything old goes
    for _ in range(3):
        log.second()
        log.writer.close()
    assert log.out.states == ["ok"]
    assert (log.folder / "000001_x.mcap" / "deep").exists()


def test_a_link_to_itself_among_the_files_does_not_end_the_recording(log: Log) -> None:
    log.folder.mkdir()
    loop = log.folder / "000001_x.mcap"
    loop.symlink_to(loop)
    log.second()
    loop.rename(log.folder / "link")
    assert log.out.states == ["ok"]
    assert log.lines() == ["text"]


@pytest.mark.parametrize("what", ["the folder", "the file"])
def test_what_is_deleted_while_recording_is_made_again(log: Log, what: str) -> None:
    log.second()
    shutil.rmtree(log.folder) if what == "the folder" else files(log.folder)[0].unlink()
    log.second(line("lost with it"))
    log.second(line("next"))
    assert log.lines() == ["next"]
    assert log.out.states == ["ok"]


def test_a_file_that_somebody_deletes_while_it_is_looked_at(
    log: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = files

    def and_gone(folder: Path) -> list[Path]:
        return [*listed(folder), folder / "000000_gone.mcap"]

    monkeypatch.setattr("gazechair.blackbox.writer.files", and_gone)
    log.second()
    log.second()
    assert log.out.states == ["ok"]


@pytest.mark.parametrize(
    "bad",
    [
        ("line", 10**9, ("no level", 5, None)),
        ("health", 10**9, 7),
        ("scan", 10**9, ("front", b"\x01")),
        ("figures", 10**9, {"x": object}),
        ("no such kind", 10**9, ""),
        ("down", 10**9, b""),
        ("line", "no time", (20, "gazechair", "x")),
    ],
    ids=lambda bad: str(bad[:1]),
)
def test_a_record_that_no_file_takes_holds_up_nothing_else(log: Log, bad: tuple[Any, ...]) -> None:
    try:
        marshal.dumps(bad)
    except ValueError:
        bad = (*bad[:2], {1: 2.5})
    log.second(line("before"), bad, line("after"))
    assert log.lines()[:1] == ["before"]
    assert "after" in log.lines()
