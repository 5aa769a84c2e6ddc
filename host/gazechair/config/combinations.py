"""Rules between settings: combinations that a configuration must not contain."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from gazechair.base.footprint import why_not
from gazechair.config.rules import is_host
from gazechair.config.settings import Config, LidarConfig


@dataclass(frozen=True)
class Broken:
    """An offending setting, `at` which of several tables of its section, and why."""

    section: str
    key: str
    reason: str
    at: int = 0


_STREAM = r"https?://(\[[^\s/?#\[\]@]+\]|[^\s/?#\[\]@:]+)(:[0-9]{1,5})?([/?#]\S*)?"


def broken(config: Config) -> Iterator[Broken]:
    """Every rule that `config` breaks."""
    if config.camera.kind == "http" and not re.fullmatch(_STREAM, config.camera.url):
        reason = (
            'must be the address of the stream when kind is "http", as http://host:port/path'
            " without spaces and without user:password@"
        )
        yield Broken("camera", "url" if config.camera.url else "kind", reason)
    yield from _lidars(config.lidar)
    for at, route in enumerate(config.routes):
        if not route.url:
            reason = "must be an address of Apprise, as ntfys://ntfy.sh/your-topic"
            yield Broken("alerts.route", "url", reason, at)
        if route.name in [other.name for other in config.routes[:at]]:
            reason = f"{route.name!r} is the name of another route; give each its own"
            yield Broken("alerts.route", "name", reason, at)
    reason = why_not(config.footprint.corners_m)
    if reason:
        yield Broken("footprint", "corners_m", f"must {reason}")
    if config.web.name and not is_host(config.web.name):
        yield Broken("web", "name", "must be a host name or an address")
    if config.web.insecure_http and config.web.tls:
        yield Broken("web", "insecure_http", "contradicts tls = true; leave one of them out")


def _lidars(lidars: tuple[LidarConfig, ...]) -> Iterator[Broken]:
    fitted = [lidar for lidar in lidars if lidar.kind == "s2"]
    for at, lidar in enumerate(lidars):
        if lidar.kind == "replay" and not lidar.file:
            reason = 'must be the file to play when kind is "replay"'
            yield Broken("lidar", "kind", reason, at)
        if lidar.name in [other.name for other in lidars[:at]]:
            reason = f"{lidar.name!r} is the name of another lidar; give each its own"
            yield Broken("lidar", "name", reason, at)
        if lidar.kind == "s2" and lidar.port == "auto" and len(fitted) > 1:
            reason = '"auto" finds one lidar only; with several give each "usb:SERIAL" or a path'
            yield Broken("lidar", "port", reason, at)
        if lidar.kind == "s2" and [other.port for other in fitted].count(lidar.port) > 1:
            yield Broken("lidar", "port", f"{lidar.port!r} is the port of another lidar", at)
