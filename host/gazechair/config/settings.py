"""Every setting of the configuration: its default, range and meaning; a class for each section."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass, field
from typing import Any

from gazechair.base.footprint import DEFAULT_CORNERS
from gazechair.config import rules
from gazechair.config.plugin_tables import PluginConfig
from gazechair.config.rules import choice, flag, integer, number, text, word
from gazechair.config.tables import setting as _setting


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


# What a person's own profile accepts, too.
DRIVING_MODES = "step", "continuous"
DWELL_MS, LEAVE_GRACE_MS, POINTER_STALE_MS = (300, 2000), (0, 500), (300, 1000)


@dataclass(frozen=True)
class DriverConfig:
    """How the driver's page behaves unless a person's own profile differs."""

    mode: str = _setting("step", choice(*DRIVING_MODES), "mode in which the page starts")
    dwell_ms: int = _setting(600, integer(*DWELL_MS), "gaze on a button this long starts it")
    leave_grace_ms: int = _setting(
        200, integer(*LEAVE_GRACE_MS), "gaze off a button this long stops it"
    )
    pointer_stale_ms: int = _setting(
        500,
        integer(*POINTER_STALE_MS),
        "a pointer that stands still this long counts as looking away",
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
