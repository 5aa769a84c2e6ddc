"""Recorded drives replay with every decision the same; a changed limit is found at its tick."""

from __future__ import annotations

import argparse
import re
from bisect import bisect_right
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fulldisk import full
from gazeboard.core import limits
from gazechair.base.user_error import UserError
from gazechair.blackbox.reader import LogFile
from gazechair.cli import refuse
from gazelink import codes
from gazelink.settings_table import TABLE
from gazereplay import as_test, command, trace
from gazereplay.recording import Recording
from gazereplay.replay import of_trace, replay
from gazereplay.result import NoTrace
from gazesim.chair_rig import LinkedChair
from recordedchair import RecordedChair

# What it is made of takes longer than the tests: one process makes it.
pytestmark = [pytest.mark.xdist_group("replay_drives"), pytest.mark.costly]


def tour(chair: RecordedChair) -> None:
    """As the demo's check drives: forward and leave, a step to the left, a wall."""
    chair.drive(ms=600)
    chair.page.release()
    chair.run(700)
    chair.page.press("left", "step")
    chair.run(2000)
    chair.page.release()
    chair.run(100)
    chair.page.press("forward")
    chair.run(300)
    chair.world.faults.inject("obstacle", ahead_m=1.6, left_m=0.0, size_m=0.2)
    chair.until(lambda: chair.override() == "obstacle_forward", 4000)
    chair.run(100)


def cable(chair: RecordedChair) -> None:
    """The cable is pulled while driving, and plugged in again."""
    chair.drive(ms=300)
    chair.cable.pull()
    chair.run(700)
    chair.cable.plug()
    chair.run(200)
    chair.page.release()
    chair.arm()
    chair.page.press("right")
    chair.run(400)
    assert chair.host is not None
    assert chair.host.link.sessions == 2


def stick(chair: RecordedChair) -> None:
    """The caretaker takes over and drives arcs."""
    chair.arm()
    caretaker = chair.another_page("caretaker")
    chair.run(60)
    caretaker.take()
    chair.run(300)
    for linear, turn in ((300, 0), (300, 200), (500, -300), (0, 250), (-200, 0)):
        caretaker.pull(linear, turn)
        chair.run(300)
    assert not chair.neutral()
    caretaker.release()
    chair.run(300)


def sensors(chair: RecordedChair) -> None:
    """Heading, joystick and lidar fail while driving; an emergency, and a reset of the board."""
    chair.drive("left", ms=300)
    chair.world.faults.inject("imu_freeze")
    chair.run(200)
    chair.world.faults.clear("imu_freeze")
    chair.run(300)
    chair.page.release()
    chair.run(50)
    chair.page.press("forward")
    chair.run(300)
    assert chair.host is not None
    chair.host.lidar_child = False
    chair.run(450)
    chair.host.lidar_child = True
    chair.run(300)
    chair.world.faults.inject("wiper_nak")
    chair.run(100)
    chair.world.faults.clear("wiper_nak")
    chair.page.release()
    chair.board.reset()
    chair.run(1000)


def stalls(chair: RecordedChair) -> None:
    """Service loop and tick stand still for a while."""
    chair.drive(ms=300)
    chair.board.blocked = True
    chair.run(80)
    chair.board.blocked = False
    chair.run(300)
    chair.page.release()
    chair.run(50)
    chair.page.press("forward")
    chair.run(200)
    chair.board.hung = True
    chair.run(30)
    chair.board.hung = False
    chair.run(1000)


def settings(chair: RecordedChair) -> None:
    """A setting is changed, then the chair drives by it."""
    chair.run(800)
    assert chair.host is not None
    index = next(at for at, row in enumerate(TABLE) if row[0] == "creep_mm_s")
    chair.host.link.protocol.request_setting(codes.SETTING_SET, index, TABLE[index][2])
    chair.run(100)
    assert chair.app.settings.creep_mm_s == TABLE[index][2]
    chair.drive(ms=300)
    chair.world.faults.inject("obstacle", ahead_m=1.1, left_m=0.0, size_m=0.2)
    chair.run(500)


DRIVES = (tour, cable, stick, sensors, stalls, settings)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Any], Path]:
    """The file of a drive, recorded once."""
    files: dict[Any, Path] = {}

    def record(drive: Any) -> Path:
        if drive not in files:
            chair = RecordedChair(tmp_path_factory.mktemp(drive.__name__))
            drive(chair)
            files[drive] = chair.close()
        return files[drive]

    return record


@pytest.mark.parametrize("drive", DRIVES)
def test_every_decision_is_the_same(drive: Any, recorded: Any) -> None:
    result = replay(recorded(drive))
    assert result.difference is None
    assert result.ticks > 1500
    assert result.armed > 300
    assert result.decisions > 10
    assert result.lives == (2 if drive is sensors else 1)


@pytest.mark.parametrize(
    ("drive", "limit", "value"),
    [
        (tour, "NEUTRAL_PROVEN_MS", 499),
        (tour, "CREEP_MOST_MM_S", 160),
        (sensors, "WIPER_TRIES", 4),
        (cable, "HOST_SILENT_MS", 99),
        (sensors, "CLEARANCE_OLD_MS", 299),
        (stalls, "SERVICE_STALLED_MS", 49),
        (stalls, "TICK_STEADY_MS", 499),
    ],
)
def test_a_changed_limit_is_found_at_the_first_tick_it_changes(
    drive: Any, limit: str, value: int, recorded: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(drive)
    assert getattr(limits, limit) != value
    monkeypatch.setattr(limits, limit, value)
    found = replay(path).difference
    assert found is not None
    assert re.match(rf"tick {found.tick} of start 1: ", str(found))
    assert replay(path).difference == found


def command_line(words: list[str]) -> int:
    """`gazechair` with these words, whatever is installed."""
    parser = argparse.ArgumentParser()
    command.add(parser.add_subparsers())
    options = parser.parse_args(words)
    try:
        return int(options.act(options))
    except UserError as error:
        return refuse(str(error))


@pytest.mark.parametrize("drive", [tour, stick, stalls])
def test_the_host_was_told_what_was_decided(drive: Any, recorded: Any) -> None:
    """Each STATE of the log is the trace's decision of the tick in which the board made it."""
    decisions: dict[int, Any] = {}
    states: list[Any] = []
    skipped = 0  # ticks that a stall left out: the board's clock counts them
    for line in LogFile(recorded(drive)).lines():
        if line.topic == trace.DECISION:
            decisions[line.message.tick] = line.message
        elif line.topic == trace.INPUTS:
            skipped += max(0, line.message.elapsed_us // 1000 - 1)
        elif line.topic == "/board/state":
            states.append((line.message, skipped))
    assert len(states) > 100
    ticks = sorted(decisions)
    for state, skipped in states:
        decided = decisions[ticks[bisect_right(ticks, state.board_ms - 1 - skipped) - 1]]
        reported = (state.status & 15, state.status >> 4, state.override, state.faults, state.edge)
        names = ("state", "motion", "override", "faults", "edge")
        assert reported == tuple(getattr(decided, name) for name in names), state


def test_a_chair_without_pages_is_recorded_too(tmp_path: Path) -> None:
    """As benchmarks drive it."""
    chair = LinkedChair()
    recording = Recording(chair, chair.link.protocol, tmp_path)

    def drive(ms: int) -> None:
        for _ in range(ms):
            chair.one_ms()
            recording.after_ms()

    drive(1000)
    chair.link.order(codes.ARM, codes.CARETAKER)
    drive(200)
    assert chair.armed()
    chair.press(codes.LEFT, codes.STEP)
    drive(1800)
    result = replay(recording.close())
    assert result.difference is None
    assert (result.ticks, result.armed > 1800) == (3000, True)


def test_the_command(recorded: Any, tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    path = str(recorded(cable))
    assert command_line(["replay", path]) == 0
    printed = capsys.readouterr().out
    assert "all decisions are the same" in printed
    monkeypatch.setattr(limits, "HOST_SILENT_MS", 120)
    assert command_line(["replay", path]) == 1
    printed = capsys.readouterr().out
    assert re.search(r"differs first at \d\d:\d\d:\d\d, tick \d+ of start 1: ", printed)
    assert "host_silent" in printed


def test_a_drive_becomes_a_test(
    recorded: Any, tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(as_test.keep, "__defaults__", (tmp_path / "drives",))
    assert command_line(["replay", str(recorded(tour)), "--as-test", "tour"]) == 0
    kept = tmp_path / "drives" / "tour.mcap"
    assert str(kept) in capsys.readouterr().out
    assert kept.stat().st_size < recorded(tour).stat().st_size
    assert replay(kept) == replay(recorded(tour))
    monkeypatch.setattr(limits, "CREEP_MOST_MM_S", 160)
    assert replay(kept).difference == replay(recorded(tour)).difference is not None
    monkeypatch.undo()
    assert command_line(["replay", str(recorded(tour)), "--as-test", "../tour"]) == 2


@pytest.mark.parametrize("kept", [0, *sorted(as_test.FOLDER.glob("*.mcap"))], ids=str)
def test_kept_drives(kept: Path | int) -> None:
    """Drives that somebody kept with `gazechair replay --as-test`; there may be none."""
    assert not kept or replay(kept).difference is None  # type: ignore[arg-type]


def test_a_cut_trace_is_played_up_to_the_cut(recorded: Any, tmp_path: Path) -> None:
    whole = recorded(tour)
    cut = tmp_path / "cut.mcap"
    for share in (0.2, 0.4, 0.6):
        cut.write_bytes(whole.read_bytes()[: int(whole.stat().st_size * share)])
        result = replay(cut)
        assert result.difference is None
        assert 0 < result.ticks < replay(whole).ticks
        assert "cut.mcap is readable up to 2026-09-21 " in result.ending
    assert not replay(whole).ending


@pytest.mark.parametrize("damaged", [False, True])
def test_it_says_where_a_log_ends_early(
    recorded: Any, tmp_path: Path, capsys: Any, damaged: bool
) -> None:
    data = bytearray(recorded(tour).read_bytes())
    data[len(data) // 2] ^= 0xFF
    cut, picture = tmp_path / "cut.mcap", tmp_path / "drive.svg"
    cut.write_bytes(data if damaged else data[: len(data) // 2])
    for words in (["replay", str(cut)], ["replay", str(cut), "--view", str(picture)]):
        assert command_line(words) == 0
        assert capsys.readouterr().out.count("cut.mcap is readable up to 2026-09-21 ") == 1
    cut.write_bytes(data[:2000])
    assert command_line(["replay", str(cut)]) == 2
    assert "no trace of the board's ticks" in (printed := capsys.readouterr().err)
    assert "cut.mcap is not readable and ends there" in printed


def test_a_drive_without_decisions_to_compare_with_is_refused(
    recorded: Any, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(cable)
    whole = of_trace(LogFile(path))
    lines = [line for line in whole if line.topic != trace.DECISION]
    monkeypatch.setattr("gazereplay.replay.of_trace", lambda _path: lines)
    with pytest.raises(NoTrace, match="no decision to compare with"):
        replay(path)
    assert command_line(["replay", str(path)]) == 2
    assert "no decision to compare with" in capsys.readouterr().err


def test_a_drive_of_an_older_version_is_replayed(
    recorded: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What its trace lacks changes no decision, or the drive is refused; or it is not compared."""
    path = recorded(cable)
    monkeypatch.setattr(trace, "TAKEN", (*trace.TAKEN, "newer"))
    monkeypatch.setattr(trace, "DECIDED", (*trace.DECIDED, "newer"))
    decision = trace.decision
    monkeypatch.setattr(trace, "decision", lambda *of: (*decision(*of), 1))
    with pytest.raises(NoTrace, match=r"no such inputs, which this core needs: newer$"):
        replay(path)
    monkeypatch.setitem(trace.NEUTRAL, "newer", 7)
    assert replay(path).difference is None


def test_a_log_without_a_trace_is_refused(tmp_path: Path, capsys: Any) -> None:
    """As a host without a board leaves it."""
    from gazechair.blackbox.writer import LogWriter

    writer = LogWriter(tmp_path, 10**8, 1e9)
    writer.write("line", 0, (20, "gazechair", "text"))
    writer.close()
    (path,) = tmp_path.iterdir()
    with pytest.raises(NoTrace):
        replay(path)
    assert command_line(["replay", str(path)]) == 2
    assert "no trace" in capsys.readouterr().err
    words = ["replay", str(path), "--view", str(tmp_path / "drive.svg")]
    assert command_line(words) == 2
    assert "has no state of a board to draw" in capsys.readouterr().err
    assert not (tmp_path / "drive.svg").exists()
    assert command_line(["replay", str(tmp_path / "none.mcap")]) == 2
    assert "none.mcap: No such file" in capsys.readouterr().err
    (tmp_path / "notes.txt").write_text("no log")
    assert command_line(["replay", str(tmp_path / "notes.txt"), *words[2:]]) == 2
    assert "notes.txt is no log" in capsys.readouterr().err
    assert not (tmp_path / "drive.svg").exists()


def test_a_view_that_cannot_be_written_is_one_line(
    recorded: Any, capsys: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("os.replace", full)
    picture = tmp_path / "drive.svg"
    assert command_line(["replay", str(recorded(cable)), "--view", str(picture)]) == 2
    printed = f"gazechair: {picture} can't be written: No space left on device\n"
    assert capsys.readouterr().err == printed
