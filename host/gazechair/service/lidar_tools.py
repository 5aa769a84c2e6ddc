"""`gazechair lidar mask` and `gazechair lidar record`: use the lidars without the daemon."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

from gazechair.base import health as states
from gazechair.base.user_error import UserError
from gazechair.commissioning.lidar_mask import learned_mask
from gazechair.config.rules import to_toml
from gazechair.config.settings import Config, LidarConfig
from gazechair.sensing.lidar.device import S2, LidarError, find_port
from gazechair.sensing.lidar.mask import Learned, MaskError
from gazechair.sensing.lidar.reader import Intake, Reader
from gazechair.sensing.lidar.scan import Arc, Scan
from gazechair.sensing.lidar.scanfile import ScanFileError, ScanWriter
from gazechair.sensing.lidar.stream import PERIODS_S, ByteStream
from gazelink import codes

_PATIENCE_S = 15.0
_SILENT_S = 2.0

Say = Callable[[str], None]


class LidarCommandError(UserError):
    """Raised when no lidar can be used for the command."""


def fitted(config: Config) -> tuple[LidarConfig, ...]:
    """The configured lidars. Raises LidarCommandError when there is none."""
    found = tuple(lidar for lidar in config.lidar if lidar.kind != "off")
    if not found:
        raise LidarCommandError(
            'no lidar is configured: set lidar.kind = "s2" and give the file with --config'
        )
    return found


def mask(config: Config, seconds: float, say: Say) -> bool:
    """Learn every lidar's mask for `seconds`, print it as TOML; False when one can't be learned."""
    lidars = fitted(config)
    say("Free 0.5 m all round the chair, a room with walls; the driver sits still. Looking ...")
    good = True
    for lidar in lidars:
        try:
            scans = _collect(lidar, seconds)
            learned = learned_mask(lidar, scans, config.footprint)
        except (MaskError, LidarCommandError) as error:
            say(f"{lidar.name}: {error}")
            good = False
        else:
            for line in _lines(lidar, learned, len(scans)):
                say(line)
    return good


def _collect(lidar: LidarConfig, seconds: float) -> list[Scan]:
    """A scan of every turn, for `seconds` from the first one on."""
    reader = Reader(lidar, lambda: None)
    scans: list[Scan] = []
    turns = -1
    end_s = time.monotonic() + _PATIENCE_S
    reader.start()
    try:
        while time.monotonic() < end_s:
            time.sleep(0.01)
            scan, stream = reader.scan, reader.stream
            if scan is not None and stream is not None and stream.turns != turns:
                if not scans:
                    end_s = time.monotonic() + seconds
                turns = stream.turns
                scans.append(scan)
    finally:
        reader.stop()
    if not scans:
        why = (
            reader.condition.detail if reader.condition.state == states.LOST else "it says nothing"
        )
        raise LidarCommandError(why)
    return scans


def _lines(lidar: LidarConfig, learned: Learned, turns: int) -> Iterator[str]:
    yield f"{lidar.name}: {turns} turns seen"
    for arcs, what in ((learned.chair, "the chair itself"), (learned.nothing, "never anything")):
        for start, end in arcs:
            yield f"  {what} at {start:g}..{end:g} degrees, left positive"
    yield f"  in its [lidar] table of the configuration, in place of {_line(lidar.mask)}:"
    yield _line(learned.mask)


def _line(arcs: tuple[Arc, ...]) -> str:
    whole = [[int(start), int(end)] for start, end in arcs]
    return f"mask = {to_toml(whole)}"


def record(config: Config, name: str | None, path: Path, seconds: float | None, say: Say) -> None:
    """Record what a lidar measures to `path`, for `seconds` or until Ctrl-C.

    `name` chooses among several lidars. Raises LidarCommandError.
    """
    lidar = _chosen([one for one in fitted(config) if one.kind == "s2"], name)
    try:
        device = S2(find_port(lidar.port))
        try:
            device.start(lidar.mode)
            header = asdict(lidar) | {
                "period_s": PERIODS_S[lidar.mode],
                "serial": device.serial.hex(),
                "recorded": time.strftime("%Y-%m-%dT%H:%M:%S"),
            }
            writer = ScanWriter(path, header)
            try:
                with contextlib.suppress(KeyboardInterrupt):
                    _record(device, lidar.mode, writer, seconds)
            finally:
                writer.close()
        finally:
            device.close()
    except (LidarError, ScanFileError) as error:
        raise LidarCommandError(str(error)) from None
    except OSError as error:
        raise LidarCommandError(f"{path} can't be written: {error.strerror}") from None
    say(f'{path}: {path.stat().st_size / 1e6:.1f} MB; play it with kind = "replay"')


def _record(device: S2, mode: str, writer: ScanWriter, seconds: float | None) -> None:
    received_s = start_s = time.monotonic()
    source = codes.SIMULATED if device.simulated else codes.REAL
    stream = ByteStream(mode, source, lambda nodes, at_s, _: writer.add(at_s - start_s, nodes))
    intake = Intake(device)
    while seconds is None or time.monotonic() - start_s < seconds:
        last_s = stream.last_s
        stream.feed(*intake.gathered(stream))
        now_s = time.monotonic()
        if stream.last_s != last_s:
            received_s = now_s
        elif now_s - received_s > _SILENT_S:
            raise LidarCommandError("the lidar fell silent; what came before is recorded")


def _chosen(lidars: list[LidarConfig], name: str | None) -> LidarConfig:
    names = ", ".join(lidar.name for lidar in lidars) or "none"
    if name is None and len(lidars) == 1:
        return lidars[0]
    for lidar in lidars:
        if lidar.name == name:
            return lidar
    raise LidarCommandError(f"say which lidar with --name; there is {names}")
