"""Measures the time from a scan's end to its clearance on the wire; real child process."""

from __future__ import annotations

import json
import os
import tempfile
import time
from pathlib import Path

from gazechair.base.health import Health
from gazechair.board.board_commands import Clearance
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.lidar import LidarService
from gazelink import frame, messages
from gazemeasure.far_end import far_end
from gazemeasure.lidar.emulator import MASK, started
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe
from gazesim.zone import reported_zone

_START_S = 20.0
_LIMIT_MS = 10.0


def wire_figures(report: Report, quick: bool) -> None:
    """Append the figures; 5 s when `quick`, else 30 s."""
    took_ms, dropped = _measure(4.0 if quick else 30.0)
    report.add(
        "scan end to clearance on the wire, median", percentile(took_ms, 0.5), "ms", _LIMIT_MS
    )
    report.add("  95 %", percentile(took_ms, 0.95), "ms")
    report.note(
        f"scan end: the emulated lidar's last byte of a turn leaves its port; wire: the frame is "
        f"written to a pty ({len(took_ms)} turns, {dropped} during stalls of the machine dropped)."
    )


def _measure(seconds: float) -> tuple[list[float], int]:
    written_s: dict[int, float] = {}
    encoder = frame.Encoder()
    encoder.session = frame.Session()
    encoder.session.begin(1, 1, bytes(4), 0, 0)
    with (
        tempfile.TemporaryDirectory(prefix="gazechair-") as folder,
        StallProbe() as probe,
        far_end(lambda far, data: None) as line,
    ):
        path = str(Path(folder) / "lidar")
        emulator = started(path)

        def publish(clearance: Clearance) -> None:
            messages.CLEARANCE.pack(encoder.body, clearance.fields(time.monotonic()))
            size = encoder.finish(messages.CLEARANCE, 0)
            os.write(line, encoder.wire[:size])
            report = service.report
            if report is not None:
                written_s.setdefault(report.lidars[0].quarters // 4, time.monotonic())

        service = LidarService(
            (LidarConfig(kind="s2", port=path, mask=MASK),),
            FootprintConfig(),
            publish,
            Health("lidar"),
        )
        try:
            service.zone(reported_zone())
            service.start()
            end_s = time.monotonic() + _START_S
            while not written_s and time.monotonic() < end_s:
                time.sleep(0.05)
            time.sleep(seconds)
        finally:
            service.stop()
            printed, _ = emulator.communicate(timeout=10.0)
        ends_s: list[float] = json.loads(printed)["turn_ends_s"]
        pairs = [(ends_s[n - 1], at) for n, at in written_s.items() if 0 < n <= len(ends_s)]
        pairs = [(end, at) for end, at in pairs if at >= end]
        good = [pair for pair in pairs if not probe.stalled(*pair)]
    return [(at - end) * 1000.0 for end, at in good], len(pairs) - len(good)
