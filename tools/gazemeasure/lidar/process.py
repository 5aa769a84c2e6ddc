"""The lidars' process as the daemon runs it, with one emulated lidar: its share of a core."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from gazechair.base.health import Health
from gazechair.board.board_commands import Clearance
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.lidar.service import LidarService
from gazemeasure.growth import cpu_s
from gazemeasure.lidar.emulator import MASK, started
from gazesim.zone import reported_zone

_START_S = 30.0
_SETTLE_S = 3.0


def core_share(seconds: float) -> tuple[float, float]:
    """(share of a core, evaluations per second) over `seconds`, once it delivers."""
    published: list[float] = []

    def count(clearance: Clearance) -> None:
        published.append(clearance.acquired_s)

    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "lidar")
        emulator = started(path)
        config = LidarConfig(kind="s2", port=path, mask=MASK)
        service = LidarService((config,), FootprintConfig(), count, Health("lidar"))
        service.zone(reported_zone())
        try:
            service.start()
            end_s = time.monotonic() + _START_S
            while not published and time.monotonic() < end_s:
                time.sleep(0.1)
            pid = service.pid
            if not published or pid is None:
                raise RuntimeError("the lidars' process delivers nothing")
            time.sleep(_SETTLE_S)
            start_s, before_s, first = time.monotonic(), cpu_s(pid), len(published)
            time.sleep(seconds)
            took_s = time.monotonic() - start_s
            return (cpu_s(pid) - before_s) / took_s, (len(published) - first) / took_s
        finally:
            service.stop()
            emulator.communicate(timeout=10.0)
