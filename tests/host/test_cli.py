"""The command line and the doctor: exit codes, one line per error, a clean end."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import pytest

from gazechair import cli
from gazechair.base.health import HealthState
from gazechair.base.sole_daemon import sole_daemon
from gazechair.config import configuration, settings
from gazechair.service import doctor, doctor_devices
from gazechair.service.doctor import FAIL, OK, WARN, Finding
from gazedemo.pairing import cookie
from gazelink import codes

PATIENCE_S = 60


def answers(board: str = "ok", lidar: str = "ok") -> dict[str, HealthState]:
    return {
        "board": HealthState(board, "ok", "", 0.0),
        "lidar": HealthState(lidar, "ok", "no lidar is configured", 0.0),
        "camera": HealthState("ok", "ok", "", 0.0),
    }


@pytest.fixture
def devices(monkeypatch: pytest.MonkeyPatch) -> dict[str, HealthState]:
    """Sets the devices' answers to the doctor."""
    found = answers()
    monkeypatch.setattr(doctor_devices, "ask", lambda _: found)
    return found


def found(findings: list[Finding], what: str) -> Finding:
    return next(finding for finding in findings if finding.what == what)


def test_config_prints_a_file_that_is_the_default(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["config"]) == 0
    assert configuration.parse(capsys.readouterr().out) == settings.Config()


def test_a_bad_configuration_ends_run_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "chair.toml"
    file.write_text("[web]\nport = -1\n")
    assert cli.main(["run", "--config", str(file)]) == 2
    printed = capsys.readouterr().err
    assert printed.startswith(f"gazechair: {file}:2: web.port must be")
    assert printed.count("\n") == 1


def test_a_taken_web_port_ends_run_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        file = tmp_path / "chair.toml"
        file.write_text(
            f'[board]\nport = "{tmp_path}/none"\n'
            f'[web]\nport = {port}\nstate_folder = "{tmp_path}"\n'
        )
        process = subprocess.run(
            [sys.executable, "-m", "gazechair", "run", "--config", str(file)],
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            env=_environment(),
        )
    assert process.returncode == 2
    assert f"{port}" in process.stderr.splitlines()[-1]
    assert "Traceback" not in process.stderr


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_run_serves_without_any_device_and_ends_cleanly(tmp_path: Path, number: int) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(
        f'[board]\nport = "{tmp_path}/none"\n[web]\nport = 0\nlanguage = "en"\n'
        f'state_folder = "{tmp_path}/state"\n'
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "gazechair", "run", "--config", str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=_environment(),
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().split()[-1]
        assert url.endswith("/?lang=en")
        request = urllib.request.Request(
            url.split("?")[0] + "health", headers={"Cookie": cookie(tmp_path / "state")}
        )
        with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
            health = json.load(answer)
        stores = {"speed_cap", "first_drive", "profiles", "devices", "alert_diary", "forward"}
        assert set(health) == {"board", "lidar", "camera", "log", "host", *stores}
        process.send_signal(number)
        assert process.wait(PATIENCE_S) == 0
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


LATE = """
import os, signal, sys, threading
from gazechair import cli
from gazechair.base.service_manager import ServiceManager

wait = threading.Condition.wait

def interrupted(condition, timeout=None):
    # Its lock is taken.
    if threading.current_thread() is threading.main_thread():
        signal.raise_signal(signal.SIGTERM)
    return wait(condition, timeout)

def ready(_manager, _status):
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGTERM)).start()
    threading.Condition.wait = interrupted

ServiceManager.ready = ready
sys.exit(cli.main(sys.argv[1:]))
"""


def test_a_stop_in_the_middle_of_waiting_for_one_ends_it(tmp_path: Path) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(
        f'[board]\nport = "{tmp_path}/none"\n[web]\nport = 0\nstate_folder = "{tmp_path}/state"\n'
    )
    process = subprocess.run(
        [sys.executable, "-c", LATE, "run", "--config", str(file)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        env=_environment(),
    )
    assert process.returncode == 0, process.stderr


def test_the_doctor_of_a_sound_machine(devices: dict[str, HealthState]) -> None:
    findings = doctor.examine(None)
    assert found(findings, "python").level == OK
    assert found(findings, "numpy").level == OK
    assert found(findings, "board").level == OK
    assert found(findings, "lidar").level == WARN  # off by default
    assert not doctor.failed(findings)


def test_a_missing_board_fails(
    devices: dict[str, HealthState], capsys: pytest.CaptureFixture[str]
) -> None:
    devices["board"] = HealthState("lost", "board_lost", "no board found; plug it in", 0.0)
    assert cli.main(["doctor", "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)
    (board,) = [row for row in rows if row["what"] == "board"]
    assert board["level"] == FAIL
    assert "plug it in" in board["found"]


def test_the_boards_faults_are_findings(cable: Any, tmp_path: Path) -> None:
    bits = (codes.RELAY_STUCK, codes.HEADING_BUS, codes.HOST_SILENT, codes.OBSTACLE_DATA_OLD)
    cable.state = {"faults": sum(1 << bit for bit in bits)}
    file = tmp_path / "chair.toml"
    file.write_text(f'[board]\nport = "{cable.path}"\n')
    faults = [one for one in doctor.examine(file) if one.what.startswith("board fault")]
    stuck = "The safety relay does not open. Switch the chair off and ask for help."
    assert faults[1:] == [Finding(FAIL, "board fault relay_stuck", stuck)]
    assert (faults[0].level, faults[0].what) == (WARN, "board fault heading_bus")


def test_a_daemon_that_runs_is_to_be_stopped_first(
    devices: dict[str, HealthState], tmp_path: Path
) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}"\n')
    assert "gazechair run" not in {one.what for one in doctor.examine(file)}
    with sole_daemon(tmp_path):
        finding = found(doctor.examine(file), "gazechair run")
    assert finding.level == WARN
    assert "sudo systemctl stop gazechair" in finding.do


@pytest.mark.parametrize("content", ["x = 1\n", "[input.gone]\nsince = 2026-09-21\n"])
def test_a_bad_configuration_is_a_finding(
    devices: dict[str, HealthState], tmp_path: Path, content: str
) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(content)
    finding = found(doctor.examine(file), "configuration")
    assert finding.level == FAIL
    assert f"{file}:{content.count(chr(10))}:" in finding.found


def test_a_missing_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_PACKAGES", ("no-such-package",))
    (finding,) = doctor._packages()
    assert (finding.level, finding.do) == (FAIL, "pip install no-such-package")


def test_the_doctor_says_whether_it_records(
    devices: dict[str, HealthState], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert found(doctor.examine(None), "log").level == OK
    monkeypatch.setattr(doctor, "find_spec", lambda _: None)
    finding = found(doctor.examine(None), "log")
    assert (finding.level, finding.do) == (WARN, "pip install 'gazechair[log]'")
    file = tmp_path / "chair.toml"
    file.write_text("[log]\nrecord = false\n")
    assert found(doctor.examine(file), "log").found == "off, as configured"


def test_the_doctor_tries_to_write_state_and_log(
    devices: dict[str, HealthState], tmp_path: Path
) -> None:
    file, state = tmp_path / "chair.toml", tmp_path / "state"
    file.write_text(f'[web]\nstate_folder = "{state}"\n')
    assert not doctor.failed(doctor.examine(file))
    assert not state.exists()  # one that root makes is of no use to the host's user
    state.mkdir()
    (state / "log").write_text("is set aside")
    assert not doctor.failed(doctor.examine(file))
    (state / "log").unlink()
    (state / "log").symlink_to("/proc/self")  # not even root writes there
    finding = found(doctor.examine(file), "log")
    assert (finding.level, finding.found[:21]) == (FAIL, "nothing is recorded: ")
    assert str(state / "log") in finding.found
    assert found(doctor.examine(file), "state folder").level == OK
    file.write_text(f'[web]\nstate_folder = "{file}"\n')
    finding = found(doctor.examine(file), "state folder")
    assert (finding.level, finding.found) == (FAIL, f"nothing is kept: {file}: Not a directory")


def test_the_doctor_names_damaged_files_and_changes_none(
    devices: dict[str, HealthState], tmp_path: Path
) -> None:
    file, state = tmp_path / "chair.toml", tmp_path / "state"
    file.write_text(f'[web]\nstate_folder = "{state}"\n')
    state.mkdir()
    names = ["alerts.jsonl", "camera_floor.json", "forward.json", "paired.jsonl"]
    names += ["profiles.json", "speed_cap"]
    for name in names:
        (state / name).write_bytes(b"\xff\n")
    reported = [
        one for one in doctor.examine(file) if one.what == "state folder" and one.level == WARN
    ]
    assert sorted(Path(one.found.partition(":")[0]).name for one in reported) == names
    assert sorted(one.name for one in state.iterdir()) == names


def test_the_doctor_says_that_the_disk_is_full(
    devices: dict[str, HealthState], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, log = tmp_path / "chair.toml", tmp_path / "log"
    file.write_text(f'[web]\nstate_folder = "{tmp_path}"\n')
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=99 << 20))
    findings = doctor.examine(file)
    assert found(findings, "state folder").level == WARN
    assert "only 99 MB are free" in found(findings, "state folder").found
    assert found(findings, "log").level == FAIL
    assert "less than 100 MB of the disk are free" in found(findings, "log").found
    log.mkdir()
    (log / "000001_x.mcap").write_bytes(bytes(1 << 20))  # the host deletes it then
    (log / "000002_x.mcap").symlink_to(log / "000002_x.mcap")
    assert found(doctor.examine(file), "log").level == OK


def test_the_text_has_a_line_for_each_finding() -> None:
    text = doctor.as_text([Finding(OK, "a", "1"), Finding(FAIL, "b", "2", "mend it")])
    assert text.splitlines() == ["OK    a: 1", "FAIL  b: 2 -> mend it"]


def test_the_doctor_says_what_to_do_where_a_part_says_nothing(
    devices: dict[str, HealthState],
) -> None:
    devices["board"] = HealthState("lost", "board_lost", "", 0.0)
    devices["camera"] = HealthState("lost", "camera_lost", "no camera: plug one in", 0.0)
    findings = doctor.examine(None)
    assert found(findings, "board").do == "Ask for help: check the USB cable."
    assert found(findings, "camera").do == ""


def _environment() -> dict[str, str]:
    return dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path))
