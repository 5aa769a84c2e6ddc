"""Assist in the daemon: runs its child process, sends it data, and applies its advice."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import asdict, replace

from gazechair.assist.message import Message, pack
from gazechair.assist.steering import Advised, Steering
from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.supervisor import Status
from gazechair.board.board_commands import Clearance, Command
from gazechair.board.zone import BoardZone
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.inbox.inbox_service import InboxService
from gazelink import codes

LOST = "assist_lost"
_TURNS = {codes.LEFT: 1, codes.RIGHT: -1}


class AssistService(InboxService):
    """Nothing waits for assist: without advice the chair drives as the driver commands.

    The child process starts when a driver first wants assist; while assist is off, it ignores data.
    """

    def __init__(
        self,
        lidars: tuple[LidarConfig, ...],
        footprint: FootprintConfig,
        health: Callable[[], Health],
        wanted: Callable[[], bool],
    ) -> None:
        """`health`: the part's, first called when the process starts; `wanted`: assist is on."""
        super().__init__(lidars)
        self._footprint = footprint
        self._health = health
        self._wanted = wanted
        self._steering = Steering()
        self._lock = threading.Lock()  # guards the message
        self._message = Message()
        self._stopped = False

    def start(self) -> None:
        """Start the child process."""
        with self._lock:
            if self._stopped:
                return
            more = {"footprint": asdict(self._footprint)}
            self._supervise(
                "gazechair.assist.child", "assist", more, lost_reason=LOST, listens=True
            )
            self._send()

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        if self._supervisor is None:
            self._lidars = lidars
        else:
            super().renew(lidars)

    def stop(self) -> None:
        with self._lock:
            self._stopped = True
        super().stop()

    def zone(self, zone: BoardZone) -> None:
        """The board's new stopping distances and times. From any thread."""
        with self._lock:
            self._message = replace(self._message, zone=zone)
            self._send()

    def clearance(self, clearance: Clearance) -> None:
        """A new clearance, as sent to the board. From any thread."""
        with self._lock:
            self._message = replace(self._message, clearance=clearance)
            if self._message.on:
                self._send()

    def steer(self, command: Command, now_s: float) -> Command:
        """The driver's command as sent to the board. From one thread at a time; never waits."""
        wanted = self._wanted()
        if wanted and self._supervisor is None:
            self.start()
        steered = self._steering.steer(command, wanted, now_s)
        alive = command.ttl_deadline_s > now_s and command.owner == codes.DRIVER
        press = command.edge if alive and steered.verb != command.verb else 0
        turns = _TURNS.get(command.verb, 0) if alive else 0
        with self._lock:
            message = replace(self._message, on=wanted, press=press, turns=turns)
            if message != self._message:
                self._message = message
                self._send()
        return steered

    def shown(self, now_s: float) -> list[bool] | None:
        """For the driver's page: [it works, it steers, it waits], see Steering; None: off."""
        if not self._wanted():
            return None
        steering = self._steering
        return [steering.works(now_s), steering.steers(now_s), steering.waits(now_s)]

    def _send(self) -> None:
        if self._supervisor is not None and not self._stopped:
            self._supervisor.send(pack(self._message))

    def _on_data(self, payload: bytes) -> None:
        ready, press, linear, turn, steers, waits, born_s = json.loads(payload)
        numbers = int(press), int(linear), int(turn)
        advised = Advised(*numbers, bool(steers), float(born_s), bool(waits))
        self._steering.advised = advised
        if ready:
            self._steering.ready_s = advised.born_s
        self._health().set(states.OK)

    def _on_status(self, status: Status) -> None:
        self._health().set(status.state, status.reason, status.detail)
