"""A board's own trace, as sent: replays equal, finds a changed limit, survives what breaks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace as changed
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gazeboard.boards import pins
from gazeboard.core import limits
from gazeboard.core.motion import Motion
from gazeboard.io import trace as board
from gazechair.blackbox.reader import Line, LogFile
from gazelink import VERSION, arcs, codes, frame, messages
from gazelink.settings_table import NO_CASTERS_Q4_DEG, index_of, profile_row
from gazereplay import as_test, board_trace, command, trace
from gazereplay.board_trace import STATE, TRACE, BoardPlayer
from gazereplay.replay import of_trace, replay
from gazereplay.result import NoTrace, Result
from tracedchair import TracedChair, drive, faults, restart

# What it is made of takes longer than the tests: one process makes it.
pytestmark = [pytest.mark.xdist_group("replay_board"), pytest.mark.costly]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Any], Path]:
    """The file of a drive, recorded once."""
    files: dict[Any, Path] = {}

    def record(driven: Any) -> Path:
        if driven not in files:
            chair = TracedChair(tmp_path_factory.mktemp(driven.__name__))
            driven(chair)
            files[driven] = chair.close()
        return files[driven]

    return record


def play(lines: Iterable[Line]) -> Result:
    """A log that something happened to."""
    player = BoardPlayer()
    for line in lines:
        player.take(line)
    return player.result


@pytest.mark.parametrize("driven", [drive, faults, restart])
def test_every_reported_decision_is_the_same(driven: Any, recorded: Any) -> None:
    path = recorded(driven)
    result = replay(path)
    assert result.difference is None
    assert result.lives == (2 if driven is restart else 1)
    assert (result.gaps, result.unchecked) == (0, 0)
    states = sum(line.topic == STATE for line in LogFile(path).lines())
    assert result.compared > 0.95 * states - 10 * result.lives
    assert result.armed > 500
    assert result.decisions >= 20


@pytest.mark.parametrize(
    ("driven", "limit", "value"),
    [
        (drive, "HOST_SILENT_MS", 80),
        (drive, "NEUTRAL_PROVEN_MS", 700),
        (drive, "RELAY_HOLD_MS", 80),
        (faults, "WIPER_TRIES", 20),
        (faults, "CLEARANCE_OLD_MS", 270),
        (faults, "SERVICE_STALLED_MS", 30),
        (faults, "TICK_STEADY_MS", 400),
    ],
)
def test_a_changed_limit_is_found_at_a_reported_tick(
    driven: Any, limit: str, value: int, recorded: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(driven)
    assert getattr(limits, limit) != value
    monkeypatch.setattr(limits, limit, value)
    found = replay(path).difference
    assert found is not None
    assert re.match(rf"tick {found.tick} of start 1: ", str(found))


def test_a_drive_becomes_a_test(
    recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(drive)
    kept = as_test.keep(path, "drive", tmp_path)
    assert replay(kept) == replay(path)
    monkeypatch.setattr(limits, "HOST_SILENT_MS", 80)
    assert replay(kept).difference == replay(path).difference is not None


def test_a_chair_whose_casters_turn_it_further_is_replayed_and_kept(tmp_path: Path) -> None:
    chair = TracedChair(tmp_path)
    chair.run(800)
    caster = index_of(profile_row(int(chair.app.settings.profile), "caster_q4_deg"))
    chair.link.protocol.request_setting(codes.SETTING_SET, caster, 2 * NO_CASTERS_Q4_DEG)
    chair.run(200)
    chair.arm()
    chair.press(codes.LEFT)
    chair.run(600)
    chair.release()
    chair.run(1000)
    path = chair.close()
    for log in (path, as_test.keep(path, "casters", tmp_path)):
        result = replay(log)
        assert result.difference is None
        assert result.compared > 100
        assert result.armed > 1000


@pytest.mark.parametrize(
    "exported", ['{"topic": "/health"}\n{"topic": "/tf"}\n', '[{"topic": "/tf"}]', "{}", "\udcff"]
)
def test_another_json_beside_a_log_changes_nothing(recorded: Any, exported: str) -> None:
    path = recorded(drive)
    result = replay(path)
    path.with_suffix(".json").write_text(exported, errors="surrogateescape")
    assert replay(path) == result


def test_a_test_kept_again_under_its_own_name_is_the_same(recorded: Any, tmp_path: Path) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    files = {file: file.read_bytes() for file in tmp_path.iterdir()}
    assert as_test.keep(kept, "drive", tmp_path) == kept
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == files
    assert replay(kept).compared > 100


def test_a_drive_that_cannot_be_kept_leaves_the_one_before(
    recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    before = kept.read_bytes()

    def full(_path: Path) -> Iterator[Line]:
        yield next(of_trace(LogFile(kept)))
        raise OSError("no space left")

    monkeypatch.setattr(as_test, "of_trace", full)
    with pytest.raises(OSError, match="no space left"):
        as_test.keep(recorded(drive), "drive", tmp_path)
    assert kept.read_bytes() == before
    assert not list(tmp_path.glob("*.new"))


@pytest.mark.parametrize("every", [15, 50, 150])
def test_after_lost_frames_nothing_is_pretended(every: int, recorded: Any) -> None:
    lines = list(of_trace(LogFile(recorded(faults))))
    whole = play(lines)
    traces = [line for line in lines if line.topic == TRACE]
    lost = set(map(id, traces[every::every]))
    result = play(line for line in lines if id(line) not in lost)
    assert result.difference is None
    assert 0 < result.ticks < whole.ticks


def test_after_a_gap_it_goes_on_with_the_next_snapshot(tmp_path: Path) -> None:
    chair = TracedChair(tmp_path)
    chair.arm()
    chair.run(100)
    for verb in (codes.LEFT, codes.FORWARD, codes.RIGHT):
        chair.press(verb)
        chair.run(1000)
        chair.link.protocol._trace_due_s = chair.now_s()
    lines = list(of_trace(LogFile(chair.close())))
    at = [k for k, line in enumerate(lines) if line.topic == TRACE]
    lost = set(at[len(at) // 2 : len(at) // 2 + 3])
    result = play(line for k, line in enumerate(lines) if k not in lost)
    whole = play(lines)
    assert result.difference is None
    assert result.gaps == 1
    assert 50 < result.unchecked < 2000
    assert result.ticks + result.unchecked == whole.ticks


def test_a_drive_from_its_middle_on(tmp_path: Path) -> None:
    """As a file of the log that begins with the hour; and one that is cut anywhere."""
    chair = TracedChair(tmp_path)
    chair.arm()
    chair.press(codes.LEFT)
    chair.run(300)
    chair.link.protocol._trace_due_s = chair.now_s()
    chair.run(700)
    lines = list(of_trace(LogFile(chair.close())))
    for k in range(0, len(lines), len(lines) // 12):
        for part in (lines[k:], lines[:k]):
            result = play(part)
            assert (result.difference, result.gaps) == (None, 0)
    first = next(k for k, line in enumerate(lines) if line.topic == TRACE)
    assert 500 < play(lines[first + 1 :]).armed < play(lines).armed - 200


def test_a_cut_file_is_played_up_to_the_cut(recorded: Any, tmp_path: Path) -> None:
    whole = recorded(drive)
    cut = tmp_path / "cut.mcap"
    ticks = 0
    for share in (0.3, 0.5, 0.8, 0.99):
        cut.write_bytes(whole.read_bytes()[: int(whole.stat().st_size * share)])
        try:
            result = replay(cut)
        except NoTrace:
            continue  # nothing of it was on the disk
        assert result.difference is None
        assert result.ticks >= ticks
        ticks = result.ticks
    assert ticks > 0


def test_a_storm_of_contacts_is_a_gap(tmp_path: Path) -> None:
    """More than the board's ring holds while its service loop stands."""
    chair = TracedChair(tmp_path)
    chair.arm()
    chair.run(200)
    chair.board.blocked = True
    for k in range(80):
        chair.bank.pin(pins.BUTTON).drive(k & 1)
        chair.run(1)
    chair.board.blocked = False
    chair.bank.pin(pins.BUTTON).drive(1)
    chair.run(500)
    result = replay(chair.close())
    assert result.difference is None
    assert result.gaps == 1
    assert 80 <= result.unchecked < 200


def test_changed_settings_are_a_short_gap(tmp_path: Path) -> None:
    chair = TracedChair(tmp_path)
    chair.run(800)
    chair.link.protocol.request_setting(codes.SETTING_DEFAULTS, 0, 0)
    chair.run(200)
    chair.arm()
    chair.press(codes.FORWARD)
    chair.run(300)
    result = replay(chair.close())
    assert result.difference is None
    assert (result.gaps, result.unchecked < 20) == (1, True)
    assert result.armed > 300


def test_another_version_of_the_core_takes_kept_drives_only(
    recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    init = Motion.__init__

    def newer(self: Any, settings: Any, turn: Any) -> None:
        init(self, settings, turn)
        self._another = 7

    monkeypatch.setattr(Motion, "__init__", newer)
    with pytest.raises(NoTrace, match="another version"):
        replay(recorded(drive))
    assert replay(kept).difference is None
    assert replay(kept).compared > 100
    again = as_test.keep(kept, "again", tmp_path)
    assert replay(again) == replay(kept)


def test_a_core_with_more_inputs_takes_kept_drives_when_it_knows_what_is_neutral(
    recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    before = replay(kept)
    fields = (*board.FIELDS[:5], "newer", *board.FIELDS[5:])
    monkeypatch.setattr(board, "FIELDS", fields)
    monkeypatch.setattr(board, "WORDS", board.WORDS + 1)
    with pytest.raises(NoTrace, match=r"no such inputs, which this core needs: newer$"):
        replay(kept)
    monkeypatch.setitem(trace.NEUTRAL, "newer", 7)
    assert replay(kept) == before
    assert before.compared > 100
    again = as_test.keep(kept, "again", tmp_path)
    assert replay(again) == before


def test_a_core_with_other_arcs_names_them(
    recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    monkeypatch.setattr(arcs, "SIZE", arcs.SIZE + 1)
    with pytest.raises(NoTrace, match=r"no such inputs, which this core needs: arcs$"):
        replay(kept)


@pytest.mark.parametrize(
    ("ours", "says"),
    [
        (((9, 9, 9), frame.schema_hash()), r"another version of the firmware \(.*, here 9\.9\.9\)"),
        ((VERSION, 7), r"another version of the firmware \(.*, with another table\)"),
    ],
)
def test_another_version_with_as_many_words_takes_kept_drives_only(
    ours: Any, says: str, recorded: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = as_test.keep(recorded(drive), "drive", tmp_path)
    monkeypatch.setattr(board_trace, "_ours", lambda: ours)
    with pytest.raises(NoTrace, match=says):
        replay(recorded(drive))
    assert replay(kept).difference is None
    assert replay(kept).compared > 100


def test_a_log_that_does_not_tell_its_version_says_so(
    recorded: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: Any
) -> None:
    lines = [line for line in of_trace(LogFile(recorded(drive))) if line.topic != board_trace.HELLO]
    result = play(lines)
    assert (result.unnamed, result.difference) == (True, None)
    assert not replay(recorded(drive)).unnamed
    monkeypatch.setattr("gazereplay.replay.replay", lambda _path: result)
    options = SimpleNamespace(file=tmp_path, view=None, as_test=None)
    assert command._replay(options) == 0  # type: ignore[arg-type]
    assert "does not name its board's version" in capsys.readouterr().out


def test_a_trace_without_reports_of_its_board_is_refused(recorded: Any, monkeypatch: Any) -> None:
    lines = [line for line in of_trace(LogFile(recorded(drive))) if line.topic != STATE]
    assert play(lines).ticks > 100
    monkeypatch.setattr("gazereplay.replay.of_trace", lambda _path: lines)
    with pytest.raises(NoTrace, match="no decision to compare with"):
        replay(recorded(drive))


def test_damaged_words_never_raise(recorded: Any) -> None:
    """A byte of each frame in turn is another: found, or a gap, but no error."""
    lines = list(of_trace(LogFile(recorded(restart))))

    def damaged() -> Iterator[Any]:
        for k, line in enumerate(lines):
            if line.topic == TRACE and k % 40 == 0:
                at = len(line.data) - 1 - k % 50
                data = line.data[:at] + bytes([line.data[at] ^ 0x55]) + line.data[at + 1 :]
                yield changed(line, data=data)
            else:
                yield line

    result = Result()
    player = BoardPlayer()
    for line in damaged():
        player.take(line)
        result = player.result
    assert result.ticks > 0
    assert messages.TRACE.size + 4 <= 64
