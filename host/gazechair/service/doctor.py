"""The doctor: examines this machine and its devices, and gives an action for each finding."""

from __future__ import annotations

import contextlib
import importlib.metadata
import json
import math
import os
import platform
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

from gazechair.alerts.mqtt import MISSING as BROKER_MISSING
from gazechair.alerts.mqtt import try_broker
from gazechair.base import health as states
from gazechair.base.languages import advice
from gazechair.base.sole_daemon import AlreadyRunning, no_daemon
from gazechair.base.state_folder import state_folder
from gazechair.board import ports
from gazechair.config import configuration
from gazechair.config.configuration import ConfigError
from gazechair.config.settings import Config
from gazechair.plugins.describe import examine as examine_plugin
from gazechair.service import doctor_devices, doctor_files

OK = "OK"
WARN = "WARN"
FAIL = "FAIL"

_PACKAGES = ("pyserial", "numpy", "flask", "rplidar-roboticia")
_FREE_MB = 100
_OUTERMOST_M = 0.75  # of the drive axle; compiled into the board as OUTERMOST_MM
_TRIED = 4096  # bytes
_TOOLS = (
    ("chromium", "shows the page in tests and screenshots"),
    ("qemu-system-arm", "runs the emulated board in tests"),
    ("micropython", "runs the virtual board; tools/demo fetches one where it is missing"),
)


@dataclass(frozen=True)
class Finding:
    """One line of the doctor's report."""

    level: str
    """OK, WARN (works without) or FAIL (does not)."""
    what: str
    found: str
    do: str = ""
    """What to do; empty if nothing."""


def examine(config_path: Path | None) -> list[Finding]:
    """All findings about this machine with the configuration that load(config_path) reads."""
    findings = [*_python(), *_packages(), *_serial_ports()]
    try:
        config = configuration.load(config_path)
    except ConfigError as error:
        return [*findings, Finding(FAIL, "configuration", str(error), "correct that line")]
    file = configuration.file_in_use(config_path)
    name = "all defaults" if file is None else str(file)
    findings.append(Finding(OK, "configuration", name))
    return [
        *findings,
        *_footprint(config),
        *_daemon(config),
        *_devices(config),
        *_plugins(config),
        *_state(config),
        *_log(config),
        *_alerts(config),
        *_tools(),
    ]


def failed(findings: list[Finding]) -> bool:
    """True if any finding is a FAIL."""
    return any(finding.level == FAIL for finding in findings)


def as_text(findings: list[Finding]) -> str:
    """One line for each finding."""
    return "\n".join(
        f"{finding.level:4}  {finding.what}: {finding.found}"
        + (f" -> {finding.do}" if finding.do else "")
        for finding in findings
    )


def as_json(findings: list[Finding]) -> str:
    """The findings as a JSON list of objects with level, what, found, do."""
    return json.dumps([asdict(finding) for finding in findings], indent=1)


def _python() -> Iterator[Finding]:
    yield Finding(OK, "python", platform.python_version())


def _packages() -> Iterator[Finding]:
    for name in _PACKAGES:
        try:
            yield Finding(OK, name, importlib.metadata.version(name))
        except importlib.metadata.PackageNotFoundError:
            yield Finding(FAIL, name, "not installed", f"pip install {name}")


def _serial_ports() -> Iterator[Finding]:
    for port in ports.seen():
        if not port.usb_id:
            continue
        what = f"{port.what} ({port.usb_id})"
        if os.access(port.path, os.R_OK | os.W_OK):
            yield Finding(OK, port.path, what)
        else:
            yield Finding(FAIL, port.path, f"{what}, not permitted to this user", ports.PERMIT)


def _footprint(config: Config) -> Iterator[Finding]:
    farthest_m = max(math.hypot(x, y) for x, y in config.footprint.corners_m)
    found = f"its farthest corner is {farthest_m:.2f} m from the drive axle"
    if round(farthest_m, 2) <= _OUTERMOST_M:
        yield Finding(OK, "footprint", found)
    else:
        found += f", the board limits turns for {_OUTERMOST_M:g} m"
        do = f"that corner turns {farthest_m / _OUTERMOST_M:.1f} times as fast: docs/obstacles.md"
        yield Finding(WARN, "footprint", found, do)


def _daemon(config: Config) -> Iterator[Finding]:
    # Another user's folder cannot be read: then its daemon is not found.
    with contextlib.suppress(OSError):
        try:
            with no_daemon(state_folder(config.web.state_folder)):
                pass
        except AlreadyRunning:
            do = "stop it first (sudo systemctl stop gazechair), and run the doctor again"
            yield Finding(WARN, "gazechair run", "runs, and has board, lidars and camera", do)


def _devices(config: Config) -> Iterator[Finding]:
    answers = doctor_devices.ask(config)
    for name, answer in answers.items():
        if name == "lidar" and all(lidar.kind == "off" for lidar in config.lidar):
            yield Finding(WARN, name, answer.detail, "without one the board does not arm")
        elif answer.state == states.OK:
            yield Finding(OK, name, answer.detail or "delivers")
        else:
            # The detail ends with what to do.
            level = WARN if answer.state == states.DEGRADED or name == "camera" else FAIL
            do = "" if answer.detail else advice(answer.reason)
            yield Finding(level, name, answer.detail or f"{answer.state}, no answer", do)


def _plugins(config: Config) -> Iterator[Finding]:
    for plugin in config.plugins:
        description = examine_plugin(plugin)
        what = f"{plugin.kind} {plugin.name}"
        if description.wrong:
            yield Finding(
                FAIL, what, description.wrong, "gazechair plugin list shows what is installed"
            )
        else:
            yield Finding(OK, what, description.about)


def _state(config: Config) -> Iterator[Finding]:
    folder = state_folder(config.web.state_folder)
    problem = _unwritable(folder)
    if problem:
        do = "name a folder that this user may write in web.state_folder"
        yield Finding(FAIL, "state folder", f"nothing is kept: {problem}", do)
        return
    free_mb = shutil.disk_usage(_existing(folder)).free >> 20
    if free_mb < _FREE_MB:
        do = "delete what is not needed"
        yield Finding(WARN, "state folder", f"{folder}; only {free_mb} MB are free", do)
    else:
        yield Finding(OK, "state folder", f"{folder}; {free_mb} MB are free")
    if folder.is_dir():
        for file in doctor_files.damaged(folder, config):
            yield Finding(WARN, "state folder", file.detail)


def _existing(folder: Path) -> Path:
    """The folder, or the one in which it would be made."""
    while not os.path.lexists(folder):
        folder = folder.parent
    return folder


def _unwritable(folder: Path) -> str:
    """Why nothing can be written there, or "". Tried: permissions alone do not show it."""
    try:
        with tempfile.TemporaryFile(dir=_existing(folder)) as file:
            file.write(bytes(_TRIED))
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        return f"{folder}: {error.strerror}"
    return ""


def _log(config: Config) -> Iterator[Finding]:
    folder = state_folder(config.web.state_folder) / "log"
    if not config.log.record:
        yield Finding(OK, "log", "off, as configured")
    elif find_spec("mcap_ros2") is None:
        yield Finding(WARN, "log", "nothing is recorded", "pip install 'gazechair[log]'")
    elif problem := _unwritable(folder.parent if folder.is_file() else folder):
        yield Finding(FAIL, "log", f"nothing is recorded: {problem}", "let this user write there")
    elif problem := _full(folder):
        yield Finding(FAIL, "log", f"nothing is recorded: {problem}", "delete what is not needed")
    else:
        bounds = f"{config.log.keep_days} days, {config.log.max_mb} MB at most"
        yield Finding(OK, "log", f"records; {bounds}")


def _full(folder: Path) -> str:
    from gazechair.blackbox import writer

    held = writer.states(writer.files(folder))
    own = sum(state.st_size for _, state in held)  # the oldest give way
    short = shutil.disk_usage(_existing(folder)).free + own < writer.KEPT_FREE
    return writer.FULL if short else ""


def _alerts(config: Config) -> Iterator[Finding]:
    names = ", ".join(route.name for route in config.routes)
    if not config.routes:
        yield Finding(OK, "alerts", "on the caretaker's page only", "read docs/alerts.md")
    elif find_spec("apprise") is None:
        yield Finding(FAIL, "alerts", "nobody is called", "pip install 'gazechair[alerts]'")
    else:
        yield Finding(OK, "alerts", names, "try them: gazechair alert test")
    if config.alerts.mqtt:
        yield _broker(try_broker(config.alerts.mqtt))


def _broker(problem: str) -> Finding:
    if not problem:
        return Finding(OK, "mqtt", "the broker answers")
    do = "" if problem == BROKER_MISSING else "check the broker and alerts.mqtt: docs/alerts.md"
    return Finding(FAIL, "mqtt", problem, do)


def _tools() -> Iterator[Finding]:
    for name, purpose in _TOOLS:
        path = shutil.which(name)
        if path is None:
            yield Finding(WARN, name, "not there", f"only needed by developers: {purpose}")
        else:
            yield Finding(OK, name, path)
