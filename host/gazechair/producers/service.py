"""A producer in the daemon: its child process, its tiles, and its news for the pages."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Clock
from gazechair.base.reasons import PLUGIN
from gazechair.base.supervisor import Status, Supervised
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.driving.mode_context import ModeContext
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.plugins import value_checks
from gazechair.plugins.child import LOST
from gazechair.plugins.exchange import RECORDS_PER_S
from gazechair.producers import exchange
from gazechair.producers.contract import CHANGED
from gazechair.producers.places import Target
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox_service import InboxService
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts, pack
from gazechair.sensing.odometry.estimate import Estimate
from gazelink import codes

# Why a motion ended, apart from the reasons of its producer and the board.
STOPPED, FAILED = "going_stopped", "going_failed"
_BOARD_REASONS = {"supervision_lost", "auto_overruled", "auto_limit"}
_BOARD_REASONS |= {name for _bit, name, _severity, _latched in codes.FAULTS}

_GOAL_FIELDS = ("map", "x", "y", "heading")
_MESSAGE_S = 0.018  # for 50 per second, with a margin
_IDLE_MESSAGE_S = 0.1
_SHOWN_S = 60.0  # how long the end of a motion is shown
_LATE_S = 0.135  # after this long without a value, its producer is the reason, not a late step
_NICE = 5  # a busy producer must not take the processor from the parts that stop the chair


Settings = Callable[[], Mapping[str, int] | None]


class Port(value_checks.Port, Protocol):
    """What this needs from Control."""

    def offer_mode(self, mode: str, tile: dict[str, Any] | None) -> None: ...
    def mode_context(self) -> ModeContext: ...


@dataclass
class _Ride:
    """One press of one of its tiles."""

    mode: str
    number: int
    target: Target
    judge: value_checks.ModeRun
    begun_s: float
    record: exchange.Record | None = None
    received_s: float = 0.0
    """When its newest value arrived that was still alive."""
    ended_s: float | None = None
    reason: str = ""
    removed: bool = False
    settings: Mapping[str, int] = field(default_factory=dict)


class ProducerService(InboxService):
    """One kind. Nothing here waits for it, and driving by hand does not need it."""

    def __init__(
        self,
        kind: str,
        lidars: tuple[LidarConfig, ...],
        setup: Mapping[str, Any],
        health: Health,
        targets: Callable[[], Mapping[str, Target]],
        clock: Clock = time.monotonic,
        pictures: int | None = None,
    ) -> None:
        """`setup` of the child, see child_setup; `targets`: what can be chosen now, by the name of
        its mode; `pictures`: descriptor of a LatestPicture."""
        super().__init__(lidars)
        self.kind = kind
        self.health = health
        self._setup = setup
        self._targets = targets
        self._pictures = pictures
        self._port: Port
        self._settings: Settings
        self._override: Callable[[], str]
        self._clock = clock
        self._lock = threading.RLock()
        self._lives = False
        self._shown: dict[str, Target] = {}
        self._offered: dict[str, Target] = {}  # those that can be pressed
        self._message_s = float("-inf")
        self._state_s = 0.0
        self._ride: _Ride | None = None  # the newest, over or not

    def connect(self, port: Port, settings: Settings, override: Callable[[], str]) -> None:
        """Call before `start`. `settings`: the board's, None: not known; `override`: the board's
        override of its newest press."""
        self._port, self._settings, self._override = port, settings, override

    def start(self) -> None:
        """Start the child process."""
        self._supervise(
            "gazechair.producers.child",
            PLUGIN,
            {"kind": self.kind, "pictures": self._pictures, **self._setup},
            () if self._pictures is None else (self._pictures,),
            lost_reason=LOST,
            listens=True,
            records_per_s=RECORDS_PER_S,
            longest=exchange.LONGEST,
            nice=_NICE,
            name=self.health.name,
        )

    def end(self) -> None:
        """End the child process and its motion. Its inbox stays until `stop`."""
        Supervised.stop(self)
        self._child_lost()

    # Its data, apart from what the lidars' child and the board write

    def estimate(self, estimate: Estimate) -> None:
        """A new estimate from odometry. Never blocks."""
        inbox.send(self.inbox_fd, inbox.pack_estimate(estimate))

    def where(self, where: Whereabouts) -> None:
        """A new pose from mapping. Never blocks."""
        inbox.send(self.inbox_fd, pack(where))

    # For the pages

    def rows(self) -> list[dict[str, Any]]:
        """Its tiles, as plug-ins' rows; `sign`: what the page draws."""
        now = self.health.now()
        with self._lock:
            return [
                {
                    "kind": "place",
                    "name": mode,
                    "sign": target.icon,
                    "names": {"nl": target.name, "en": target.english or target.name},
                    "state": now.state,
                    "reason": now.reason,
                    "detail": "",
                    "again": None,
                }
                for mode, target in self._shown.items()
            ]

    def news(self) -> dict[str, Any] | None:
        """The newest motion: goal, path, state or reason of its end; None: none recently."""
        with self._lock:
            ride = self._ride
            if ride is None:
                return None
            if ride.ended_s is not None and self._clock() - ride.ended_s > _SHOWN_S:
                return None
            record = ride.record
            state = "thinks" if record is None else record.state
            if ride.ended_s is not None:
                state = "arrived" if state == "arrived" else "ended"
            shown = dict(record.shown) if record is not None else {}
            goal = {key: ride.target.more[key] for key in _GOAL_FIELDS if key in ride.target.more}
            reason = ride.reason or ("" if record is None else record.reason)
            return {
                **shown,
                "kind": self.kind,
                "mode": ride.mode,
                "name": ride.target.name,
                "state": state,
                "reason": "" if state == "arrived" else reason,
                "goal": goal or shown.get("goal", {}),
            }

    # Periodic calls

    def look(self) -> None:
        """Update what can be chosen: 4 times a second. May wait for a disk; none waits for it."""
        shown = dict(self._targets()) if self._settings() else {}
        with self._lock:
            self._shown = shown
            self._offer()

    def tick(self) -> None:
        """Call 250 times a second while its mode is pressed, else 50 times. Never blocks."""
        with self._lock:
            now_s = self._clock()
            context = self._port.mode_context()
            self._follow(context, now_s)
            self._send_message(context, now_s)

    @property
    def rides(self) -> bool:
        """True while its mode is pressed."""
        return self._ride is not None and self._ride.ended_s is None

    @property
    def begun_s(self) -> float:
        """When the newest motion began, by its clock; -inf: none has."""
        ride = self._ride
        return float("-inf") if ride is None else ride.begun_s

    def _offer(self, stopped: bool = False) -> None:
        """`stopped`: a motion whose mode goes was stopped; else its target has changed."""
        wanted = self._choices() if self._lives else {}
        for mode, target in list(self._offered.items()):
            if wanted.get(mode) != target:
                del self._offered[mode]
                if self.rides and self._ride is not None and self._ride.mode == mode:
                    self._ride.removed = not stopped
                self._port.offer_mode(mode, None)
        for mode, target in wanted.items():
            if mode not in self._offered:
                self._offered[mode] = target
                self._port.offer_mode(mode, {"auto": True})

    def _choices(self) -> Mapping[str, Target]:
        """What can be pressed, by its mode."""
        return self._shown

    def _follow(self, context: ModeContext, now_s: float) -> None:
        ride = self._ride
        if ride is not None and ride.ended_s is None:
            if (ride.mode, ride.number) == (context.mode, context.press):
                return
            self._end(ride, now_s)
        target = self._offered.get(context.mode)
        if target is None or (ride is not None and ride.number == context.press):
            return
        settings = self._settings()

        def within(linear: int, turn: int) -> tuple[int, int]:
            cap = self._port.mode_context().cap_permille
            return ChairNumbers.of(settings or {}).within(linear, turn, cap)

        judge = value_checks.ModeRun(self._port, context.mode, self._clock, True, within)
        self._ride = _Ride(
            context.mode,
            context.press,
            target,
            judge,
            now_s,
            received_s=now_s,
            settings=settings or {},
        )
        self._message_s = float("-inf")
        if settings is None:  # unknown since the last look: nothing can be planned
            self._ride.ended_s, self._ride.reason = now_s, FAILED
            self._port.mode_output(context.mode, context.press, None, now_s, False)

    def _end(self, ride: _Ride, now_s: float) -> None:
        ride.ended_s = now_s
        self._message_s = float("-inf")
        if ride.record is not None and ride.record.state in ("arrived", "ended"):
            return
        override = self._override()
        if not self._lives or (
            override not in _BOARD_REASONS and now_s - ride.received_s > _LATE_S
        ):
            ride.reason = FAILED
        elif ride.removed:
            ride.reason = CHANGED
        else:
            ride.reason = override if override in _BOARD_REASONS else STOPPED

    def _send_message(self, context: ModeContext, now_s: float) -> None:
        rides = self.rides
        if rides and (context.state_s == self._state_s or now_s - self._message_s < _MESSAGE_S):
            return
        if not rides and now_s - self._message_s < _IDLE_MESSAGE_S:
            return
        self._message_s, self._state_s = now_s, context.state_s
        message: dict[str, Any] = {"at_s": now_s, "press": 0, **self._extra_fields()}
        if rides and self._ride is not None:
            message |= {
                "at_s": context.state_s,  # while the board is silent, do not drive on
                "press": self._ride.number,
                "target": dict(self._ride.target.more),
                "settings": dict(self._ride.settings),
                "may_reverse": context.view["backward"] != "unseen",
                "cap_permille": context.cap_permille,
            }
        self._send(json.dumps(message).encode())

    def _extra_fields(self) -> Mapping[str, Any]:
        """Additional fields of a message."""
        return {}

    def _send(self, message: bytes) -> None:
        if self._supervisor is not None:
            self._supervisor.send(message)

    def _on_data(self, payload: bytes) -> None:
        record = exchange.unpack(payload)
        with self._lock:
            self._take_answer(record)
            if not self._lives:
                self._lives = True
                self._offer()
            ride = self._ride
            if ride is not None and ride.ended_s is None:
                value = ride.judge.take(record.value, record.state == "arrived")
                if value.press == ride.number:
                    ride.record = record
                    if ride.judge.lives(value):
                        ride.received_s = self._clock()
        self.health.set(states.OK)

    def _take_answer(self, record: exchange.Record) -> None:
        """Process a record about a chosen spot."""

    def _on_status(self, status: Status) -> None:
        if status.state == states.LOST:
            self._child_lost()
        reason = f"plugin_{status.how}" if status.how else status.reason
        self.health.set(status.state, reason, status.detail)

    def _child_lost(self) -> None:
        with self._lock:
            self._lives = False
            self._offer()


def child_setup(footprint: FootprintConfig, maps: Path, state: Path) -> dict[str, Any]:
    """The child's setup; `maps`: the folder of the stored maps, `state`: the state folder."""
    margins = footprint.front_margin_m, footprint.side_margin_m, footprint.rear_margin_m
    outline = {"corners_m": footprint.corners_m, "margins_m": margins}
    return {"footprint": outline, "maps": str(maps), "state": str(state)}
