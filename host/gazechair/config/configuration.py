"""The configuration: one TOML file, whose defaults work on a bare machine."""

from __future__ import annotations

import argparse
import ipaddress
import os
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from gazechair.base.footprint import DEFAULT_CORNERS
from gazechair.base.told import ToldError
from gazechair.config import combinations, plugin_tables, rules, tables
from gazechair.config.plugin_tables import PluginConfig
from gazechair.config.rules import choice, flag, integer, number, text, word
from gazechair.config.tables import BadSetting
from gazechair.config.tables import setting as _setting

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


class ConfigError(ToldError):
    """Raised for a file that is refused. Its text is one line: file, line, reason, what to do."""


@dataclass(frozen=True)
class BoardConfig:
    """The microcontroller board."""

    port: str = _setting(
        "auto", text(), 'serial port of the board: "auto" finds it by USB ids, or a path'
    )


@dataclass(frozen=True)
class LidarConfig:
    """The obstacle sensor; several have one [[lidar]] table each. Without one, no arming."""

    kind: str = _setting(
        "off",
        choice("off", "s2", "replay"),
        "s2 = RPLIDAR S2; replay = a recorded scan file; off = none fitted",
    )
    name: str = _setting("lidar", word(), "what it is called on the page and in the log")
    port: str = _setting(
        "auto",
        text(),
        'serial port of the lidar: "auto" finds the only one by its USB ids,'
        ' "usb:SERIAL" the adapter with that serial number; or a path',
    )
    file: str = _setting(
        "", text(), "the scan file to replay, as `gazechair lidar record` wrote it"
    )
    mode: str = _setting(
        "dense", choice("dense", "standard"), "dense = 32,000 points/s up to 30 m, with a checksum"
    )
    x_m: float = _setting(
        0.5, number(-2.0, 2.0), "where it sits: metres before the drive wheels' axle"
    )
    y_m: float = _setting(0.0, number(-2.0, 2.0), "metres to the left of the chair's middle")
    heading_deg: float = _setting(
        0.0, number(-180.0, 180.0), "direction of its front, counter-clockwise from forward"
    )
    upside_down: bool = _setting(False, flag(), "true = it hangs from its base")
    mask: tuple[rules.Arc, ...] = _setting(
        (),
        rules.arcs(300.0),
        "arcs [from, to] in its own view, counter-clockwise, 0 = its front, in which the chair"
        " itself is in the way; `gazechair lidar mask` finds them",
    )


@dataclass(frozen=True)
class OdometryConfig:
    """The chair's pose and speed, measured by its lidars. Read docs/odometry.md."""

    measure: bool = _setting(True, flag(), "false = not measured; the chair drives without it")


@dataclass(frozen=True)
class CameraConfig:
    """The picture behind the buttons. The chair drives without it."""

    kind: str = _setting(
        "off",
        choice("off", "usb", "oak", "http"),
        "usb = webcam; oak = Luxonis OAK (extra); http = MJPEG stream of an IP camera",
    )
    device: str = _setting("", text(), "usb: /dev/video...; empty = the first that makes MJPEG")
    width: int = _setting(640, integer(160, 1920), "usb, oak: pixels")
    height: int = _setting(480, integer(120, 1080), "usb, oak: pixels")
    rate_hz: int = _setting(15, integer(1, 30), "usb, oak: pictures a second")
    url: str = _setting("", text(), "http: where the stream is, http://host:port/path")


@dataclass(frozen=True)
class WebConfig:
    """The server of the driver's page."""

    host: str = _setting("127.0.0.1", rules.host(), "address to listen on; 0.0.0.0 = every network")
    port: int = _setting(8080, integer(0, 65535), "TCP port; 0 = any free one")
    name: str = _setting(
        "", text(), 'name or address by which tablets reach this host; "" = its network address'
    )
    tls: bool = _setting(
        False, flag(), "true = encrypt on this machine too; other machines always are encrypted"
    )
    insecure_http: bool = _setting(
        False, flag(), "true = let other machines in without TLS (shown on the page)"
    )
    state_folder: str = _setting(
        "",
        text(),
        'paired devices and certificate; "" = $STATE_DIRECTORY, or ~/.local/state/gazechair',
    )
    language: str = _setting("nl", rules.language(), "language of a new person's page")


@dataclass(frozen=True)
class DriverConfig:
    """How the driver's page behaves unless a person's own profile differs."""

    mode: str = _setting("step", choice("step", "continuous"), "mode in which the page starts")
    dwell_ms: int = _setting(600, integer(300, 2000), "gaze on a button this long starts it")
    leave_grace_ms: int = _setting(200, integer(0, 500), "gaze off a button this long stops it")
    pointer_stale_ms: int = _setting(
        500, integer(300, 1000), "a pointer that stands still this long counts as looking away"
    )
    assist: bool = _setting(
        False, flag(), "true = Rijhulp steers while Vooruit is held; read docs/assist.md"
    )
    backward: bool = _setting(False, flag(), "true = show the button that drives backward")


@dataclass(frozen=True)
class FootprintConfig:
    """The chair's outline on the floor with driver and foot rests, and the required margins.

    In the chair's frame: the drive wheels' axle is [0, 0], x forward, y to the left.
    """

    corners_m: tuple[tuple[float, float], ...] = _setting(
        DEFAULT_CORNERS, rules.corners(), "its corners one after another, no side crossing"
    )
    front_margin_m: float = _setting(0.05, number(0.0, 0.5), "kept clear before it, at least")
    side_margin_m: float = _setting(
        0.02, number(0.0, 0.3), "kept clear at each side; a door needs over twice this more"
    )
    rear_margin_m: float = _setting(0.05, number(0.0, 0.5), "kept clear behind it, at least")


@dataclass(frozen=True)
class LogConfig:
    """The black box: what happened, in files of the state folder. Read docs/log.md."""

    record: bool = _setting(True, flag(), "false = nothing is recorded")
    keep_days: int = _setting(30, integer(1, 365), "older files are deleted")
    max_mb: int = _setting(
        4000, integer(50, 1000000), "of all files together; the oldest are deleted first"
    )
    pictures: bool = _setting(False, flag(), "true = a small picture of the camera each second")


ALERT_KINDS = ("help", "stuck", "failure", "system")


@dataclass(frozen=True)
class AlertsConfig:
    """Who is called when the driver or the chair needs somebody. Read docs/alerts.md."""

    stuck_s: int = _setting(
        60, integer(10, 3600), "overruled this long without moving on, the chair counts as stuck"
    )
    mqtt: str = _setting(
        rules.Secret(""),
        rules.broker(),
        "broker that Home Assistant uses (extra); mqtts:// encrypts; secret",
    )


@dataclass(frozen=True)
class RouteConfig:
    """One way to reach somebody outside the caretaker's page; several have a table each."""

    name: str = _setting("route", word(), "what it is called on the page and in the diary")
    url: str = _setting(
        rules.Secret(""), rules.address(), "an Apprise service's address (extra); secret, not shown"
    )
    after_s: int = _setting(
        0, integer(0, 3600), "used, too, for an alert that nobody has answered for this long"
    )
    kinds: tuple[str, ...] = _setting(
        ALERT_KINDS, rules.choices(*ALERT_KINDS), "which alerts use this route"
    )


@dataclass(frozen=True)
class Config:
    """Everything that can be configured, by section."""

    board: BoardConfig = field(default_factory=BoardConfig)
    lidar: tuple[LidarConfig, ...] = (LidarConfig(),)
    odometry: OdometryConfig = field(default_factory=OdometryConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)
    web: WebConfig = field(default_factory=WebConfig)
    driver: DriverConfig = field(default_factory=DriverConfig)
    footprint: FootprintConfig = field(default_factory=FootprintConfig)
    log: LogConfig = field(default_factory=LogConfig)
    alerts: AlertsConfig = field(default_factory=AlertsConfig)
    routes: tuple[RouteConfig, ...] = ()
    """Of [[alerts.route]]."""
    plugins: tuple[PluginConfig, ...] = ()
    """Enabled inputs and modes, each with its own table."""


# Sections that may occur several times, as [[name]].
SEVERAL = ("lidar",)

SECTIONS: dict[str, type[Any]] = {
    "board": BoardConfig,
    "lidar": LidarConfig,
    "odometry": OdometryConfig,
    "camera": CameraConfig,
    "web": WebConfig,
    "driver": DriverConfig,
    "footprint": FootprintConfig,
    "log": LogConfig,
    "alerts": AlertsConfig,
}
_ROUTE = "alerts.route"
_VARIABLE = "GAZECHAIR_CONFIG"  # set by the Debian package's command


def file_in_use(path: Path | None) -> Path | None:
    """`path`, or when it is None the file that $GAZECHAIR_CONFIG names; None: the defaults."""
    named = os.environ.get(_VARIABLE)
    return Path(named) if path is None and named else path


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add `--config FILE`; options.config is what load() takes."""
    text = "configuration file (default: the one that $GAZECHAIR_CONFIG names, or none)"
    parser.add_argument("--config", type=Path, metavar="FILE", help=text)


def load(path: Path | None) -> Config:
    """The configuration in the `file_in_use`.

    Raises ConfigError, one line long: a missing file, broken TOML, an unknown key, a bad value.
    """
    file = file_in_use(path)
    if file is None:
        return Config()
    try:
        content = file.read_text(encoding="utf-8-sig")  # Windows editors
    except OSError as error:
        named = f"${_VARIABLE} names it; " if path is None else ""
        raise ConfigError(
            f"{file}: cannot be read ({error.strerror}); {named}give an existing file with --config"
        ) from None
    except UnicodeDecodeError:
        raise ConfigError(f"{file}: is not UTF-8 text; save it as UTF-8") from None
    return parse(content, str(file))


def parse(content: str, name: str = "configuration") -> Config:
    """The configuration in TOML text `content`, called `name` in errors. Raises ConfigError."""
    try:
        document = tomllib.loads(content)
    except (ValueError, RecursionError) as error:  # also of endless numbers
        why = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise ConfigError(_broken_toml(content, name, why)) from None
    known = ", ".join((*SECTIONS, *plugin_tables.KINDS))
    sections: dict[str, Any] = {}
    plugins: list[PluginConfig] = []
    routes: list[dict[str, Any]] = []
    for section, values in document.items():
        if section in plugin_tables.KINDS:
            try:
                plugins += plugin_tables.parse(section, values, content, name)
            except BadSetting as refused:
                if refused.key:
                    raise ConfigError(refused.reason) from None
                _refuse(content, name, section, None, refused.reason)
            continue
        if section not in SECTIONS:
            if values == {}:  # of a newer version, whose defaults all hold
                continue
            _refuse(content, name, section, None, f"is no section; there are {known}")
        if section == "alerts" and isinstance(values, dict):
            routes = values.pop("route", [])
            if not isinstance(routes, list) or not all(isinstance(one, dict) for one in routes):
                _refuse(content, name, _ROUTE, None, f"is one of several: write it as [[{_ROUTE}]]")
        tables = values if section in SEVERAL and isinstance(values, list) else [values]
        if not tables or not all(isinstance(table, dict) for table in tables):
            _refuse(content, name, section, None, f"is a section: write it as [{section}]")
        read = [_section(content, name, section, at, table) for at, table in enumerate(tables)]
        sections[section] = tuple(read) if section in SEVERAL else read[0]
    if routes:
        read = [_section(content, name, _ROUTE, at, table) for at, table in enumerate(routes)]
        sections["routes"] = tuple(read)
    config = Config(**sections, plugins=tuple(plugins))
    for rule in combinations.broken(config):
        _refuse(content, name, rule.section, rule.key, rule.reason, rule.at)
    return config


def _section(content: str, name: str, section: str, at: int, values: dict[str, Any]) -> object:
    try:
        table = RouteConfig if section == _ROUTE else SECTIONS[section]
        return tables.read(table, values, f"[{section}]")
    except BadSetting as refused:
        _refuse(content, name, section, refused.key, refused.reason, at)


def uses_tls(web: WebConfig) -> bool:
    """True if the page is encrypted: always where other machines connect, unless insecure_http."""
    return web.tls or not (is_loopback(web.host) or web.insecure_http)


def is_loopback(host: str) -> bool:
    """True if only this machine can reach an address bound to `host`."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def annotated_default() -> str:
    """A configuration file without a setting; comments have each one's default and meaning.

    What is not set is not refused by a version that does not have it yet.
    """
    lines = ["# Configuration of gazechair. To change a default, remove the # before its name."]
    for section, table in SECTIONS.items():
        lines += ["", *tables.described(table, section)]
    lines += ["", *(f"# {line}".rstrip() for line in tables.described(RouteConfig, f"[{_ROUTE}]"))]
    lines += ["", "# Inputs and modes: [input.NAME], [mode.NAME]; `gazechair plugin list`."]
    return re.sub(r"^(?=\w+ = )", "#", "\n".join(lines), flags=re.MULTILINE) + "\n"


def _refuse(
    content: str, name: str, section: str, key: str | None, reason: str, at: int = 0
) -> NoReturn:
    # `at`: in which of several tables of that section.
    what = section if key is None else f"{section}.{key}"
    raise ConfigError(f"{name}:{rules.line_of(content, section, key, at)}: {what} {reason}")


def _broken_toml(content: str, name: str, message: str) -> str:
    found = re.search(r"at line (\d+)", message)
    line = int(found.group(1)) if found else content.count("\n") + 1
    return f"{name}:{line}: is not TOML: {message}; compare with `gazechair config`"
