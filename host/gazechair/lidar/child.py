"""The lidar's child process: reads the S2, decodes, measures the sectors, reports the newest."""

from __future__ import annotations

import json
import sys
import time

from gazechair.children import RecordWriter, enter_child
from gazechair.lidar.device import S2, LidarError, find_port, stale_backlog
from gazechair.lidar.nodes import NodeDecoder
from gazechair.lidar.report import LOST, STARTING, Report
from gazechair.lidar.sectors import Sector, measure
from gazechair.lidar.sweep import Sweep
from gazelink import codes

_GATHER_S = 0.02  # bytes are taken in pieces of about a fifth of a turn
_READ_S = 0.25
_SILENT_S = 1.0


def run(port: str, sectors: tuple[Sector, ...], out: RecordWriter) -> None:
    """Serve one lidar until it fails (LidarError) or the parent closes the pipe."""
    port = find_port(port)
    out.status("starting", STARTING, f"opening the lidar at {port}")
    device = S2(port)
    try:
        out.status("starting", STARTING, f"lidar {device.serial.hex()} found, starting its motor")
        device.start()
        _stream(device, sectors, out)
    finally:
        device.close()


def _stream(device: S2, sectors: tuple[Sector, ...], out: RecordWriter) -> None:
    source = codes.SIMULATED if device.simulated else codes.REAL
    decoder = NodeDecoder()
    sweep = Sweep(source)
    last_s = time.monotonic()
    while True:
        data = device.read(_READ_S)
        now_s = time.monotonic()
        if stale_backlog(data):
            # Bytes of unknown age: start afresh, from what is measured now.
            decoder, sweep = NodeDecoder(), Sweep(source)
            continue
        nodes = decoder.feed(data)
        scan = sweep.add(nodes, now_s)
        if scan is not None:
            last_s = now_s
            if sweep.turns >= 2:  # before that there is no whole turn
                report = Report(
                    tuple(measure(scan.angles_deg, scan.distances_m, s) for s in sectors),
                    scan.acquired_s,
                    source,
                    points=len(scan),
                    turns=sweep.turns,
                    resyncs=decoder.resyncs,
                )
                out.data(report.pack())
        elif now_s - last_s > _SILENT_S:
            raise LidarError("the lidar sends no measurements; is its motor turning?")
        time.sleep(_GATHER_S)


def main() -> int:
    """Entry of `python -m gazechair.lidar.child '{"port": ..., "sectors": [[dir, from, to]]}'`."""
    argument = json.loads(sys.argv[1])
    out = enter_child()
    try:
        run(argument["port"], tuple(Sector(*s) for s in argument["sectors"]), out)
    except LidarError as error:
        out.status("lost", LOST, str(error))
        return 1
    except BrokenPipeError:
        return 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
