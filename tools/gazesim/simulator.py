"""The whole simulation in real time: world, board process, ports, camera and control socket."""

from __future__ import annotations

import fcntl
import os
import time
from collections import deque
from pathlib import Path
from typing import Any

from gazesim.bank import Bank
from gazesim.board_process import BoardProcess
from gazesim.cable import Cable
from gazesim.camera import Camera
from gazesim.control import Control
from gazesim.emulated_board import EmulatedBoard
from gazesim.faults import Argument, Fault
from gazesim.pty_port import PtyPort
from gazesim.rooms import Room
from gazesim.world import ONE, TWO, World

EMULATED = "m7:"
_STEP_S = 0.001
_STALL_S = 0.020  # longest wall time that a pass catches up: a stalled PC pauses the world
_TICK_STALL_S = 0.100  # ticks may pause this long on a stalled PC before the relay opens
_CONTROL_S = 0.005
_BOARD_S = 0.050
_WIPER_LOG = 1000
_NUMBER_LIMIT = 1e6  # of numbers in requests


class Simulator:
    """The simulator as a process sees it; `folder` gets the ports, the bank, the board's files.

    `interpreter` runs the firmware: a path or "cpython" (see BoardProcess), or "m7:" and the
    folder of the emulated Teensy, which starts with this checkout's firmware in its flash.
    `lidars`: 1, in front, or 2, on opposite corners.

    Call everything from one thread: the board's process lives as long as that thread.
    """

    def __init__(
        self,
        folder: Path,
        interpreter: str,
        room: str = "living",
        profile: str = "3.1",
        lidars: int = 1,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._lock = os.open(folder / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._lock)
            raise ValueError(f"{folder} is in use by another simulator") from error
        self.bank = Bank(folder / "bank")
        self.bank.power_on()
        mounts = TWO if lidars == 2 else ONE
        self.world = World(self.bank, room, profile, tick_stall_s=_TICK_STALL_S, mounts=mounts)
        self.cable = Cable(folder / "board")
        self.board = self._make_board(interpreter)
        names = ("lidar", "lidar-2")[: len(mounts)]
        self.lidar_ports = [PtyPort(folder / name) for name in names]
        self.lidar_port = self.lidar_ports[0]
        self.camera = Camera(self._scene)
        self.world.faults.add(self, RIG_FAULTS)
        self.control = Control(folder / "control", self.handle)
        self.stopping = False
        self._wiper_log: deque[tuple[int, float, int, int, int]] = deque(maxlen=_WIPER_LOG)
        self._wiper_changes = 0
        self._powered = True

    def _make_board(self, interpreter: str) -> BoardProcess | EmulatedBoard:
        common = (self.bank, self.folder / "bank", self.folder / "files", self.cable)
        if not interpreter.startswith(EMULATED):
            return BoardProcess(interpreter, *common)
        emulated = EmulatedBoard(Path(interpreter[len(EMULATED) :]), *common, counted=True)
        emulated.install()
        return emulated

    def start(self) -> None:
        """Start everything.

        Raises OSError when the board's interpreter cannot be run or a port cannot be made.
        """
        for port in self.lidar_ports:
            port.plug()
        self.cable.start()
        self.camera.start()
        try:
            self.board.start()
        except OSError as error:
            raise OSError(f"the board does not start: {error}") from error

    def stop(self) -> None:
        """End everything that was started."""
        self.control.close()
        self.board.stop()
        self.cable.stop()
        for port in self.lidar_ports:
            port.unplug()
        self.camera.stop()
        os.close(self._lock)

    def run(self, until_s: float | None = None) -> None:
        """Let time pass until `stopping`, or until CLOCK_MONOTONIC `until_s`."""
        last_s = control_s = board_s = time.monotonic()
        owed_s = 0.0
        while not self.stopping and (until_s is None or last_s < until_s):
            time.sleep(_STEP_S)
            now_s = time.monotonic()
            owed_s += min(now_s - last_s, _STALL_S)
            last_s = now_s
            for port, lidar in zip(self.lidar_ports, self.world.lidars, strict=True):
                if command := port.read():
                    lidar.receive(command)
            while owed_s >= _STEP_S:
                owed_s -= _STEP_S
                self._step(now_s)
            if now_s >= control_s:
                control_s = now_s + _CONTROL_S
                self.control.poll()
            if now_s >= board_s:
                board_s = now_s + _BOARD_S
                self.board.poll()

    def _step(self, now_s: float) -> None:
        wipers = self.world.wipers
        self.world.step(_STEP_S)
        for port, scan in zip(self.lidar_ports, self.world.scans, strict=True):
            if scan:
                port.write(scan)  # data that the host does not read in time is lost
        if self.world.wipers != wipers:
            self._wiper_changes += 1
            self._wiper_log.append(
                (self._wiper_changes, now_s, *self.world.wipers, self.bank.tick_ms)
            )

    def switch_off(self) -> None:
        """Take the board's power away."""
        self._powered = False
        self.board.kill()
        self.world.power_off()

    def switch_on(self) -> None:
        """Give it back."""
        self._powered = True
        self.world.power_on()
        self.board.power_cycle()

    def reset_board(self) -> None:
        """Reset the board, if it has power."""
        if self._powered:
            self.board.restart()

    def _scene(self) -> tuple[Room, tuple[float, float, float]]:
        return self.world.room, self.world.pose

    def handle(self, request: dict[str, Any]) -> dict[str, Any]:
        """Answer one control request. Raises ValueError with the reason for an invalid one."""
        do = request.get("do")
        if do == "truth":
            return self.world.truth()
        if do == "faults":
            return {"faults": self.world.faults.meanings()}
        if do == "inject":
            arguments = {k: v for k, v in request.items() if k not in ("do", "fault")}
            self.world.faults.inject(_text(request, "fault"), **arguments)
        elif do == "clear":
            self.world.faults.clear(_text(request, "fault"))
        elif do == "pull_cable":
            self.world.faults.inject("cable_pulled")
        elif do == "plug_cable":
            self.world.faults.clear("cable_pulled")
        elif do == "teleport":
            pose = [_number(request, key) for key in ("x_m", "y_m", "heading_deg")]
            self.world.teleport(*pose)
        elif do == "profile":
            self.world.chair.set_profile(_text(request, "name"))
        elif do == "wiper_log":
            since = int(_number(request, "since"))
            entries = [entry for entry in self._wiper_log if entry[0] > since]
            return {
                "entries": [list(entry[:4]) for entry in entries],
                "ticks": [entry[4] for entry in entries],  # the board's own time of each
                "last": self._wiper_changes,
            }
        elif do == "quit":
            self.stopping = True
        else:
            raise ValueError(f"can't do {do!r}; can do {', '.join(_CAN_DO)}")
        return {"ok": True}


_CAN_DO = (
    "truth",
    "faults",
    "inject",
    "clear",
    "pull_cable",
    "plug_cable",
    "teleport",
    "profile",
    "wiper_log",
    "quit",
)


def _text(request: dict[str, Any], key: str) -> str:
    value = request.get(key)
    if not isinstance(value, str):
        raise ValueError(f"{request['do']} needs {key!r}, a name")
    return value


def _number(request: dict[str, Any], key: str) -> float:
    value = request.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{request['do']} needs {key!r}, a number")
    if not -_NUMBER_LIMIT <= value <= _NUMBER_LIMIT:
        raise ValueError(f"{request['do']}: {key} is not within +/- {_NUMBER_LIMIT:g}")
    return value


def _unplug_lidar(simulator: Simulator) -> None:
    simulator.lidar_port.unplug()


def _plug_lidar(simulator: Simulator) -> None:
    if not simulator.lidar_port.plugged:
        simulator.world.lidar.power_on()
        simulator.lidar_port.plug()


def _set_camera(simulator: Simulator, off: bool, stalled: bool) -> None:
    simulator.camera.off, simulator.camera.stalled = off, stalled


RIG_FAULTS = (
    Fault(
        "cable_pulled",
        "the board's USB plug is pulled",
        lambda simulator: simulator.board.pull_cable(),
        lambda simulator: simulator.board.plug_cable(),
    ),
    Fault(
        "cable_damage",
        "shares of the bytes both ways are wrong, lost or doubled; all are late",
        lambda simulator, **damage: simulator.cable.set_damage(**damage),
        lambda simulator: simulator.cable.set_damage(),
        (
            Argument("corrupt", 0.0, 0.0, 1.0),
            Argument("drop", 0.0, 0.0, 1.0),
            Argument("duplicate", 0.0, 0.0, 1.0),
            Argument("delay_ms", 0.0, 0.0, 10_000.0),
        ),
    ),
    Fault("lidar_unplugged", "the lidar's USB plug is pulled", _unplug_lidar, _plug_lidar),
    Fault(
        "board_hang",
        "the board stops in the middle of whatever it does",
        lambda simulator: simulator.board.pause(),
        lambda simulator: simulator.board.resume(),
    ),
    Fault(
        "board_off",
        "the board has no power, nor have the devices on its 3.3 V",
        lambda simulator: simulator.switch_off(),
        lambda simulator: simulator.switch_on(),
    ),
    Fault("board_reset", "the board resets", lambda simulator: simulator.reset_board()),
    Fault(
        "camera_off",
        "the camera refuses everybody",
        lambda simulator: _set_camera(simulator, off=True, stalled=False),
        lambda simulator: _set_camera(simulator, off=False, stalled=False),
    ),
    Fault(
        "camera_stalled",
        "the camera sends no new picture",
        lambda simulator: _set_camera(simulator, off=False, stalled=True),
        lambda simulator: _set_camera(simulator, off=False, stalled=False),
    ),
)
