"""Control: connects pages, arbiter, link and error handler; the DriverPort of a running host."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable
from typing import Any

from gazechair.alerts.watch import Situation
from gazechair.base import health as states
from gazechair.base.health import HealthRegistry, HealthState
from gazechair.base.latest_value import Clock
from gazechair.board.board_commands import STOP_COMMAND, Bypass, Clearance, Command
from gazechair.board.state import BoardLimits, BoardState
from gazechair.config.settings import Config
from gazechair.driving.arbiter import LOOK_S, Arbiter
from gazechair.driving.driver_port import Message
from gazechair.driving.error_handler import ErrorHandler, Problem, Verdict, of_host
from gazechair.driving.messages import MAX_SINCE_MS, STOP, BadMessage, PageMessage, UseMode, parse
from gazechair.driving.mode_context import ModeContext, ModeOutput, sensed
from gazechair.driving.needs import Calls, Link
from gazechair.driving.refusal import Refusal
from gazechair.driving.shown_state import board_fields, bypass_ms
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.driving.step_turns import StepTurns
from gazechair.driving.stops import StopSeen
from gazechair.driving.untuned import slowed
from gazechair.people.profiles import ProfileRefused, Profiles, house_fields
from gazechair.sensing.clearance.shown import shown
from gazelink import codes

HEARTBEAT_MS = 25


class Control:
    """The DriverPort. Lock order: this object's, then the link's; callbacks hold neither."""

    def __init__(
        self,
        config: Config,
        link: Link,
        parts: HealthRegistry,
        picture_age_s: Callable[[], float | None] = lambda: None,
        clock: Clock = time.monotonic,
        profiles: Profiles | None = None,
        speed_cap: SpeedCapStore | None = None,
        alerts: Calls | None = None,
        steer: Callable[[Command, float], Command] = lambda command, _now_s: command,
    ) -> None:
        """`picture_age_s`: the age of the newest picture, None before the first; `profiles`: those
        on disk, None: the configured one, in memory; `speed_cap`: the speed cap's file;
        `alerts` None: calls reach pages only; `steer`: corrects the command to the board."""
        self._config, self._link, self._parts = config, link, parts
        self._picture_age_s = picture_age_s
        self._clock = clock
        self._profiles = profiles or Profiles(None, house_fields(config))
        self._lock = threading.Condition()
        self._speed_cap = speed_cap or SpeedCapStore(None)
        self._arbiter = Arbiter(secrets.randbelow(256), secrets.randbelow(1 << 30))
        self._arbiter.cap_permille = self._speed_cap.read()
        self._alerts, self._steer = alerts, steer
        if alerts is not None:
            self._arbiter.help.restore(alerts.help_wanted, alerts.answered_s)
        self._stop_seen, self._step_turns = StopSeen(), StepTurns()
        self._errors, self._drivers_errors = ErrorHandler(), ErrorHandler()
        self._verdict = self._drivers_verdict = Verdict("ok", "ok")
        self._limits: BoardLimits | None = None  # as last reported by the board
        self._sent = STOP_COMMAND
        self._sent_bypass: Bypass | None = None
        self._clearance: Clearance | None = None
        self._tiles: dict[str, Message] = {}  # of each mode that can be chosen
        self._plugins: Callable[[], list[Message]] = list
        self._shown: tuple[Any, ...] = ()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="arbiter", daemon=True)
        self._version, self._late_s = 0, 0.0
        self.alive_s = time.monotonic()
        """CLOCK_MONOTONIC seconds at which its thread last ran."""

    def start(self) -> None:
        """Start the thread that calls tick(), and that of the speed cap's file."""
        self.alive_s = time.monotonic()
        self._thread.start()
        self._speed_cap.start()

    def stop(self) -> None:
        """Stop the chair, disarm it, and end the threads. The link must still be running."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(5.0)
        self._link.command(STOP_COMMAND)
        self._link.order(codes.DISARM, codes.NOBODY)
        self._speed_cap.stop()

    # For the other parts

    def clearance(self, clearance: Clearance) -> None:
        """The clearance from the newest scans, to be sent to the board."""
        self._link.clearance(clearance)
        self._clearance = clearance

    def role(self, client: int) -> str:
        """The role of a page, "viewer" for one that has closed."""
        with self._lock:
            return self._arbiter.role(client)

    def join(self, role: str) -> int:
        """Add an input of a driver or a caretaker; its client id, for act() and disconnect()."""
        with self._lock:
            return self._arbiter.connect(role, self._clock(), is_input=True)

    def proof(self, born_s: float) -> int:
        """The proof for the time `born_s` in a message to act()."""
        return self._arbiter.tokens.token(born_s)

    def proven(self, proof: int) -> tuple[float, bool]:
        """The moment that the proof of a page's message stands for, and whether it is fresh."""
        return self._arbiter.tokens.proven(proof, self._clock())

    def press_number(self) -> int:
        """The board's number for a press of the host's own."""
        with self._lock:
            return self._arbiter.press_number()

    def stopped_s(self, but: int = 0) -> float:
        """When anyone except the client `but` last sent a stop of any kind, monotonic s."""
        return self._arbiter.stops.of_others_s(but)

    def owned(self) -> bool:
        """True while a page drives, or has just requested to."""
        return self._arbiter.owner is not None

    def act(self, client: int, meaning: PageMessage) -> Refusal | None:
        """Act on a message from a page or an input; a refusal if it was not followed."""
        with self._lock:
            now_s = self._clock()
            self._read_board(now_s)  # the arbiter must know what the page has seen
            was_permille = self._arbiter.cap_permille
            offered = not isinstance(meaning, UseMode) or meaning.mode in self._tiles
            refusal = self._arbiter.receive(client, meaning, now_s, offered)
            if meaning is STOP and not self._arbiter.is_input(client):
                self._stop_seen.requested(client, now_s)
            if self._arbiter.cap_permille != was_permille:
                self._speed_cap.keep(self._arbiter.cap_permille)
            self._send_to_board()
        return refusal

    def offer_mode(self, mode: str, tile: Message | None) -> None:
        """Offer `mode` under this tile of the page from now on; None: no longer."""
        with self._lock:
            now_s = self._clock()
            if tile is None:
                self._tiles.pop(mode, None)
                press = self._arbiter.mode_press[1]
                self._arbiter.mode_output(mode, press, None, 0.0, now_s, False)
            else:
                self._tiles[mode] = tile
            self._arbiter.auto_modes = frozenset(m for m, t in self._tiles.items() if t.get("auto"))
            self._refresh(now_s)

    def show_plugins(self, rows: Callable[[], list[Message]]) -> None:
        """Set the source of all enabled plug-ins, as pages show them."""
        self._plugins = rows

    def mode_output(
        self, mode: str, number: int, output: ModeOutput, till_s: float, reached: bool = True
    ) -> None:
        """The output of `mode` in its press `number`; see Arbiter.mode_output."""
        with self._lock:
            now_s = self._clock()
            self._read_board(now_s)
            self._arbiter.mode_output(mode, number, output, till_s, now_s, reached)
            self._send_to_board()

    def mode_context(self) -> ModeContext:
        """What modes may know now."""
        with self._lock:
            (mode, press), cap = self._arbiter.mode_press, self._arbiter.cap_permille
        seen = self._link.state(), self._clearance, self._clock(), self._clearance_old_s()
        return sensed(mode, press, *seen, cap)

    def situation(self) -> Situation:
        """What may be a reason to call somebody now."""
        with self._lock:
            now_s, parts, state = self._clock(), self._parts.states(), self._link.state()
            armed = state is not None and state.state == codes.ARMED
            command = self._arbiter.command
            return Situation(
                call=self._arbiter.help.on,
                calls=self._arbiter.help.count,
                coming=self._arbiter.help.coming(now_s),
                press=command.edge,
                wants=command.verb != codes.STOP and command.ttl_deadline_s > now_s,
                overruled=state is not None and armed and state.override != codes.NO_REASON,
                moving=state is not None and state.motion != codes.STOPPED,
                problems=frozenset(one.key for one in self._problems(parts, state, now_s)),
                lost={
                    name: part.detail or part.reason
                    for name, part in parts.items()
                    if part.state == states.LOST and name not in ("board", "lidar", "camera")
                },
                starting=any(part.state == states.STARTING for part in parts.values()),
            )

    def answer_call(self) -> None:
        """A caretaker has answered the driver's call by acknowledging the alert."""
        with self._lock:
            self._arbiter.help.answer(self._clock())

    def person(self) -> Message:
        """The profile of the present driver."""
        return self._profiles.chosen()

    def update(self) -> None:
        """Process a change of the board or of a part's health."""
        with self._lock:
            self._refresh(self._clock())

    def take_late_s(self) -> float:
        """The longest delay of its thread since the last call, s."""
        late_s, self._late_s = self._late_s, 0.0
        return late_s

    # DriverPort

    def connect(self, role: str) -> int:
        with self._lock:
            return self._arbiter.connect(role, self._clock())

    def disconnect(self, client: int) -> None:
        with self._lock:
            self._arbiter.disconnect(client)
            self._stop_seen.gone(client)
            self._refresh(self._clock())

    def welcome(self, client: int) -> Message:
        return {
            "k": "welcome",
            "role": self.role(client),
            "simulated": self._simulated(),
            "backward": self._config.driver.backward,
            "heartbeat_ms": HEARTBEAT_MS,
            "token_ms": MAX_SINCE_MS,
            "command_ttl_ms": self._limits and self._limits.command_ttl_ms,
            "latched": [name for _, name, _, latched in codes.FAULTS if latched],
            "modes": [{"mode": name, **tile} for name, tile in sorted(self._tiles.items())],
            "plugins": self._plugins(),
        }

    def receive(self, client: int, message: Message) -> list[Message]:
        try:
            meaning = parse(message)
        except BadMessage as error:
            return [Refusal("message", "bad_message", str(error)).message()]
        refusal = self.act(client, meaning)
        return [] if refusal is None else [refusal.message()]

    def snapshot(self, client: int) -> Message:
        with self._lock:
            now_s = self._clock()
            state = self._link.state()
            drives = self._arbiter.role(client) == "driver"
            verdict = self._drivers_verdict if drives else self._verdict
            return {
                "k": "state",
                "token": self._arbiter.tokens.token(now_s),
                **self._facts(self._parts.states(), state, now_s),
                **shown(self._clearance, now_s, self._clearance_old_s()),
                **vars(verdict),
                "you": self._arbiter.owner == client,
                "edge": self._arbiter.page_edge(client),
                "heading_deg": state.heading_deg if state and state.heading_known else None,
                "output_permille": [state.linear_permille, state.turn_permille] if state else None,
                "stops": self._stop_seen.seen(client),
                "bypass_ms": bypass_ms(self._arbiter.bypass, self._link.stats()),
            }

    def token(self) -> int:
        with self._lock:
            return self._arbiter.tokens.token(self._clock())

    def wait_change(self, timeout_s: float, last_version: int) -> int:
        with self._lock:
            self._lock.wait_for(lambda: self._version != last_version, timeout_s)
            return self._version

    def profiles(self) -> Message:
        return self._profiles.as_json()

    def change_profile(self, request: Message, role: str) -> Message:
        try:
            if role == "viewer":
                raise ProfileRefused("not_allowed", "a viewer changes nothing")
            return self._profiles.change(request, role == "caretaker")
        except ProfileRefused as refusal:
            return {"reason": refusal.reason, "detail": str(refusal)}

    def health(self) -> Message:
        return dict(self._parts.as_json())

    # Inside

    def _run(self) -> None:
        while not self._stopping.wait(LOOK_S):
            self.update()
            now_s = time.monotonic()
            self._late_s = max(self._late_s, now_s - self.alive_s - LOOK_S)
            self.alive_s = now_s

    def _read_board(self, now_s: float) -> BoardState | None:
        state = self._link.state()
        if state is not None:
            self._stop_seen.board(state.motion_name == "stopped", state.received_s)
        self._step_turns.board(state, self._sent)
        board = self._link.board()
        if board is not None and board.limits != self._limits:
            self._limits = board.limits
            self._arbiter.ttl_s = board.limits.command_ttl_ms / 1000
        shown = (codes.DISARMED, 0) if state is None else (state.state, state.edge)
        override = codes.NO_REASON if state is None else state.override
        session = 0 if board is None or state is None else board.session
        self._arbiter.board(session, *shown, now_s, override)
        return state

    def _refresh(self, now_s: float) -> None:
        state = self._read_board(now_s)
        self._send_to_board()
        parts = self._parts.states()
        problems = self._problems(parts, state, now_s)
        self._verdict = self._errors.fold(problems, now_s)
        drivers = (problem for problem in problems if not problem.caretaker_only)
        self._drivers_verdict = self._drivers_errors.fold(drivers, now_s)
        shown = (
            self._facts(parts, state, now_s),
            # Sources of each page's own fields, and of `welcome`.
            (self._verdict, self._drivers_verdict),
            self._arbiter.owner,
            None if state is None else state.edge,
            self._stop_seen.all_seen(),
            self._arbiter.bypass is None,
            self._limits,
            tuple(self._tiles),
            tuple(part.state for part in parts.values()),
        )
        if shown != self._shown:
            self._shown = shown
            self._version += 1
            self._lock.notify_all()

    def _facts(
        self, parts: dict[str, HealthState], state: BoardState | None, now_s: float
    ) -> Message:
        """Part of a snapshot that is the same for all pages, and that they get once it changes."""
        help_call = self._arbiter.help
        return {
            **board_fields(state),
            **{name: parts[name].state for name in ("board", "lidar", "camera")},
            "owner": codes.OWNERS[self._arbiter.owner_code],
            "auto": [self._arbiter.auto, self._arbiter.auto_over],
            "cap_permille": self._arbiter.cap_permille,
            "call": help_call.on,
            "coming": help_call.coming(now_s),
            "heard": self._arbiter.caretaker_is_there(now_s)
            or (self._alerts is not None and self._alerts.reaches_somebody()),
            "alerts": self._alerts.revision if self._alerts else 0,
            "profile": self._profiles.revision,
            "simulated": self._simulated(),
            "turned": self._step_turns.turned,
        }

    def _problems(
        self, parts: dict[str, HealthState], state: BoardState | None, now_s: float
    ) -> list[Problem]:
        clearance, silent = self._clearance, self._arbiter.page_silent
        age_s = None if clearance is None else now_s - clearance.acquired_s
        return of_host(parts, state, age_s, self._picture_age_s(), silent)

    def _send_to_board(self) -> None:
        # Orders first: nothing may move between the decision to disarm and its order.
        for action, owner in self._arbiter.take_orders():
            self._link.order(action, owner)
        command = self._steer(self._arbiter.command, self._clock())
        command = slowed(command, self._link.state())
        if command != self._sent:
            self._sent = command
            self._link.command(command)
        bypass = self._arbiter.bypass
        if bypass != self._sent_bypass:
            self._sent_bypass = bypass
            self._link.bypass(bypass)

    def _clearance_old_s(self) -> float:
        return self._limits.clearance_old_ms / 1000 if self._limits else 0.0

    def _simulated(self) -> bool:
        board, clearance = self._link.board(), self._clearance
        source = codes.REAL if clearance is None else clearance.source
        return source != codes.REAL or (board is not None and board.simulated)
