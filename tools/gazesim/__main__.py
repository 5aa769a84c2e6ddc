"""`python -m gazesim`: the simulator in real time, with the firmware as its board.

When ready it prints one JSON line with the board's and the lidar's ports, the camera and the
control socket. SIGTERM, SIGINT or the control socket's quit end it and everything it started.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from pathlib import Path

from gazechair.service.flash import FlashError
from gazesim.board_process import CPYTHON
from gazesim.chair import PROFILES
from gazesim.simulator import EMULATED, Simulator

_READY_S = 20.0


def main() -> int:
    """Run the simulator; returns the exit code: 0 ended, 1 the board did not start, 2 bad usage."""
    parser = argparse.ArgumentParser(prog="gazesim", description="a simulated chair in a room")
    parser.add_argument("--dir", type=Path, required=True, help="folder for ports and files")
    parser.add_argument(
        "--micropython", default=CPYTHON, help="path of a MicroPython to run the board, or cpython"
    )
    parser.add_argument(
        "--board", metavar="m7:FOLDER", help="an emulated Teensy instead of a virtual board"
    )
    parser.add_argument("--room", default="living", help="living, wall, open, flat, home-NUMBER")
    parser.add_argument("--profile", choices=tuple(PROFILES), default="3.1")
    parser.add_argument("--lidars", type=int, choices=(1, 2), default=1)
    arguments = parser.parse_args()
    if arguments.board and not arguments.board.startswith(EMULATED):
        parser.error(f"--board {arguments.board}: must be {EMULATED} and the emulation's folder")
    interpreter = arguments.board or arguments.micropython
    sys.setswitchinterval(0.0005)  # the camera's thread must not delay the board's bytes
    try:
        what = arguments.room, arguments.profile, arguments.lidars
        simulator = Simulator(arguments.dir, interpreter, *what)
    except (OSError, ValueError, FlashError) as error:
        print(f"gazesim: {error}", file=sys.stderr)
        return 2

    def end(*_: object) -> None:
        simulator.stopping = True

    signal.signal(signal.SIGTERM, end)
    signal.signal(signal.SIGINT, end)
    try:
        return _run(simulator)
    finally:
        simulator.stop()


def _run(simulator: Simulator) -> int:
    try:
        simulator.start()
    except OSError as error:
        print(f"gazesim: {error}", file=sys.stderr)
        return 2
    give_up_s = time.monotonic() + _READY_S
    while not simulator.stopping and not simulator.bank.tick_ms:
        simulator.run(until_s=time.monotonic() + 0.02)
        if time.monotonic() > give_up_s:
            log = simulator.folder / "files" / "board.log"
            print(f"gazesim: the board does not tick; see {log}", file=sys.stderr)
            return 1
    if simulator.stopping:
        return 0
    ready = {
        "ready": True,
        "board": str(simulator.cable.port.path),
        "lidar": str(simulator.lidar_port.path),
        "lidar_2": str(simulator.lidar_ports[-1].path),
        "camera": simulator.camera.url,
        "control": str(simulator.control.path),
    }
    print(json.dumps(ready), flush=True)
    simulator.run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
