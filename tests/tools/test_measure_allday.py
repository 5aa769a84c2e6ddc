"""The all-day benchmark in small and in virtual time: a minute's drive, cuts, replays, slopes."""

from __future__ import annotations

import json
import math
import os
import random
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.web import certificate
from gazedemo.check import NEUTRAL
from gazemeasure.allday import alerts, kill, power, real, record, service, virtual
from gazemeasure.allday import faults as allday_faults
from gazemeasure.allday import replay as allday_replay
from gazemeasure.allday.chair import DayChair
from gazemeasure.allday.faults import DAEMON, Fault, Well, faults, shuffled
from gazemeasure.growth import Holding, slope_per_hour
from gazemeasure.report import Figure, Report
from gazereplay.replay import replay
from gazereplay.result import NoTrace, Result


def test_a_slope_is_per_hour_and_a_peak_does_not_move_it() -> None:
    points = [(float(s), 100.0 + s / 3600) for s in range(0, 3600, 10)]
    assert slope_per_hour(points) == pytest.approx(1.0)
    points[20] = (200.0, 5000.0)
    assert slope_per_hour(points) == pytest.approx(1.0, rel=0.01)
    assert slope_per_hour([(float(s), 7.0) for s in range(100)]) == 0.0
    assert math.isnan(slope_per_hour(points[:2]))


def test_what_a_process_holds() -> None:
    holding = Holding()
    holding.look(os.getpid(), 1.0)
    assert holding.memory_mb[0][1] > 5
    assert holding.threads[0][1] >= 1
    assert holding.files[0][1] >= 3


def test_every_part_fails_in_every_way_before_one_does_again() -> None:
    count = len(faults())
    plan = shuffled(random.Random(1), 2 * count)
    assert set(plan[:count]) == set(plan[count:]) == set(faults())
    assert sum(fault.part == DAEMON for fault in plan) == 6


def test_the_unit_file_is_what_systemd_does() -> None:
    assert service.setting_s("RestartSec") == 0.1
    assert service.setting_s("WatchdogSec") == 2.0
    with pytest.raises(KeyError):
        service.setting_s("NoSuchSetting")


def test_some_seconds_of_a_day() -> None:
    report = Report("")
    day = virtual.live(virtual.Life(3.0, seed=14, fault_each=1))
    virtual.add_rows(report, [day], 3.0)
    figures = {figure.name.strip(): figure.value for figure in report.figures}
    assert figures["faults while driving"] >= 1
    assert figures["not driving again by arm and press"] == 0, report.table()
    assert figures["driving again, p95"] <= 5


def test_the_whole_day_on_record_keeps_its_limits() -> None:
    assert record.FILE is not None
    stored = json.loads(record.FILE.read_text())
    figures = {figure["name"].strip(): figure for figure in stored["figures"]}
    assert figures["virtual day: hours driven"]["value"] >= virtual.DAY_S / 3600
    assert figures["not driving again by arm and press"]["value"] == 0
    assert stored["ok"]
    assert all(figure["ok"] for figure in stored["figures"])


def test_a_record_says_whether_the_files_are_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "allday.json"
    assert record.sentence(file) == "No whole day in virtual time is on record."
    day = Report("")
    day.add("hours driven", 24.01, "h", 24.0, at_least=True)
    record.write(day, file)
    assert record.sentence(file).startswith("On record: a day of 24.0 h, within its limits")
    assert "with these files" in record.sentence(file)
    monkeypatch.setattr(record, "digest", lambda: "of changed files")
    assert "with other files" in record.sentence(file)
    day.add("not driving again", 1, "", 0)
    record.write(day, file)
    assert "FELL SHORT" in record.sentence(file)


def test_a_record_that_cannot_be_written_leaves_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "allday.json"
    day = Report("")
    day.add("hours driven", 24.01, "h", 24.0, at_least=True)
    record.write(day, file)
    before = file.read_text()
    write = Path.write_text

    def full(path: Path, text: str) -> int:
        write(path, text[:20])
        raise OSError("No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space"):
        record.write(day, file)
    assert file.read_text() == before


def test_a_drive_is_replayed_equal(tmp_path: Path) -> None:
    chair = DayChair(tmp_path, record=True)
    allday_replay.cable(chair)
    result = replay(chair.close())
    assert result.difference is None
    assert result.armed > 300


@pytest.mark.parametrize("store", power.STORES, ids=lambda store: str(store.file))
def test_a_file_of_the_state_folder_is_old_or_new_wherever_the_power_goes(
    store: power.Store,
) -> None:
    dice = random.Random(1)
    cuts = power.cut_writing(store, 20, dice)
    assert (cuts.half, cuts.dead) == (0, [])
    cuts = power.cut_file(store, 20, dice)
    assert (cuts.half, cuts.dead) == (0, [])
    assert power.unsynced(store) == 0


def test_a_file_that_is_half_written_or_replaced_too_soon_is_found(tmp_path: Path) -> None:
    def write(folder: Path, number: int) -> None:
        (folder / "speed_cap").write_text(f"{number * 111}\n")

    careless = power.Store("speed_cap", write, lambda at: SpeedCapStore(at).read())
    assert power.cut_writing(careless, 20, random.Random(1)).half > 0
    assert power.unsynced(careless) > 0


def test_each_version_of_a_state_file_reads_differently(tmp_path: Path) -> None:
    for number, store in enumerate(power.STORES):
        found = []
        for version in (1, 2):
            store.write(tmp_path / str(number), version)
            found.append(store.read(tmp_path / str(number)))
        assert found[0] != found[1], store.file


def test_a_truncated_file_that_reads_as_something_else_is_found() -> None:
    def write(folder: Path, number: int) -> None:
        (folder / "text").write_text("old" if number == 1 else "newer")

    def read(folder: Path) -> str:
        return (folder / "text").read_text() if (folder / "text").exists() else ""

    careless = power.Store("text", write, read)
    assert power.cut_file(careless, 20, random.Random(1)).half > 0


def test_a_certificate_is_usable_wherever_the_power_goes() -> None:
    assert power.cut_certificate(9, random.Random(2)) == []


def test_a_certificate_whose_authority_is_damaged_falls_short(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(certificate.Certificate, "_ask", lambda *_: None)
    failures = power.cut_certificate(30, random.Random(2))
    assert any(failure.startswith("tls, authority.crt") for failure in failures)


def figures_of(report: Report) -> dict[str, Figure]:
    return {figure.name.strip(): figure for figure in report.figures}


def test_neutral_after_a_kill_must_have_been_measured() -> None:
    for neutral_ms, ok, kept in (([90.0], True, 50.0), ([], False, 0.0)):
        report = Report("")
        kill.add_rows(report, neutral_ms, [0.1, 0.2], [Well(4.0, 0.0)])
        assert report.ok == ok
        assert figures_of(report)["measured without a stall"].value == kept


def test_a_daemon_and_its_lidars_wait_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    waited = {7: 3.0, 8: 2.0}
    monkeypatch.setattr(allday_faults, "waited_s", lambda pid: waited.get(pid, 0.0))
    monkeypatch.setattr(allday_faults, "children", lambda _pid: {"lidar": 8, "camera": 9})
    assert allday_faults.daemon_waited_s(7) == 3.0
    recovery: Any = allday_faults.Recovery.__new__(allday_faults.Recovery)
    recovery._stack = SimpleNamespace(pid=lambda _name: 7)
    assert recovery.waited_s(DAEMON) == 3.0
    assert recovery.waited_s("lidar") == 2.0


def test_a_camera_stands_still_for_longer_than_its_health_takes_to_say_so() -> None:
    assert allday_faults._PLUGS["camera", "stands still"][1] > 3.0


def test_a_press_that_never_reaches_the_wipers_falls_short() -> None:
    calm: Any = SimpleNamespace(stalled=lambda *_: False)
    stalled: Any = SimpleNamespace(stalled=lambda *_: True)
    still, moved = [1, 5.0, *NEUTRAL], [2, 5.02, 200, 170]
    assert alerts._to_wipers_ms(5.0, [still, moved], calm) == pytest.approx([20.0])
    assert alerts._to_wipers_ms(5.0, [still], calm) == [math.inf]
    assert alerts._to_wipers_ms(5.0, [still], stalled) == []


@pytest.mark.parametrize("delivers", [("anna", "bert"), ("anna",), ()])
def test_a_flood_of_which_a_route_delivers_nothing_falls_short(
    delivers: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = [100.0]
    pressed_s = [0.0]

    def sleep(seconds: float) -> None:
        now_s[0] += seconds

    def press() -> float:
        pressed_s[0] = now_s[0]
        return now_s[0]

    clock = SimpleNamespace(monotonic=lambda: now_s[0], sleep=sleep)
    monkeypatch.setattr(alerts, "time", clock)
    target = alerts.Target()
    target._server.server_close()

    def call(on: bool = True) -> float:
        if on and now_s[0] > 101.0 and not target.received:
            target.received.extend((name, now_s[0]) for name in delivers)
        return now_s[0]

    row = {"number": 1, "state": "open"}
    calls = SimpleNamespace(alerts=lambda **_: [row], call=call, seen=lambda: True)
    wipers = SimpleNamespace(
        do=lambda *_, **__: {"last": 0, "entries": [[0, pressed_s[0] + 0.01, 0, 0]]}
    )
    stack = SimpleNamespace(control=lambda: wipers)
    driver = SimpleNamespace(arm=lambda: None, press=press, release=lambda: None)
    calm = SimpleNamespace(stalled=lambda *_: False)
    report = Report("")
    alerts._flood(report, stack, calls, driver, target, calm, 10.0)  # type: ignore[arg-type]
    short = [figure.name.strip() for figure in report.figures if not figure.ok]
    assert short == ["both routes have delivered"] * (len(delivers) < 2)


def test_restarts_are_due_to_faults_of_the_daemon() -> None:
    for how, aborted, due in (("killed", 0, 1), ("stopped", 1, 1), ("starved", 0, 0)):
        assert real.restarts_due(Fault(DAEMON, how), aborted) == due
    assert real.restarts_due(Fault(DAEMON, "starved"), 2) == 1
    assert real.restarts_due(Fault("lidar", "killed"), 1) == 0


@pytest.mark.parametrize(("lived_s", "lasts_s", "ok"), [
    (1700.0, 1800.0, True), (300.0, 1800.0, False), (100.0, 160.0, True),
])  # fmt: skip
def test_a_whole_run_judges_growth(lived_s: float, lasts_s: float, ok: bool) -> None:
    holding = Holding()
    for second in range(0, round(lived_s) + 1, 10):
        for points in (holding.memory_mb, holding.threads, holding.files):
            points.append((float(second), 7.0))
    person: Any = SimpleNamespace(to_wipers=list(holding.files), presses=1000)
    report = Report("")
    real._add_growth(report, holding, 0.0, person, lasts_s)
    assert report.ok == ok


def test_replayed_drives_must_have_been_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = [tmp_path / "a", tmp_path / "b"]

    def rows(result: Result | None) -> Report:
        def replay(path: Path) -> Result:
            if result is None or path == logs[1]:
                raise NoTrace("none")
            return result

        monkeypatch.setattr(real, "replay", replay)
        report = Report("")
        real._add_replay(report, logs, 20.0)
        return report

    good = rows(Result(ticks=20_000, compared=2000, unchecked=100))
    assert good.ok
    assert figures_of(good)["files without a trace"].value == 1
    assert not rows(Result(ticks=20_000, compared=0)).ok
    assert not rows(Result(ticks=20_000, compared=2000, unchecked=5000)).ok
    assert not rows(None).ok
