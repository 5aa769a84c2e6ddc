"""The guide of the first drive: runs one step at a time, each an existing procedure.

The caretaker's page takes the terminal's place: lines instead of output, answers instead of typed
input, a held button instead of the key that stops.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np

from gazechair.base.health import HealthRegistry
from gazechair.base.refused import Refused
from gazechair.base.user_error import UserError
from gazechair.board.board_commands import Clearance
from gazechair.board.caretaker_settings import CaretakerSettings, ChangeRefused
from gazechair.board.link import BoardLink
from gazechair.commissioning.board_settings import BoardSettings, SettingRefused
from gazechair.commissioning.calibrate.joystick import JoystickCalibration
from gazechair.commissioning.lidar_mask import learned_mask
from gazechair.commissioning.tune import StoppedError
from gazechair.commissioning.tune.armed_session import Hands
from gazechair.commissioning.tune.forward import ForwardNumbers, ForwardRecording
from gazechair.commissioning.tune.forward_runner import ForwardRunner, Measured
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazechair.commissioning.tune.runner import Runner
from gazechair.commissioning.tune.tuning import Tuning
from gazechair.commissioning.watched_areas import PERMITTED_S, with_eyes
from gazechair.config.settings import Config, LidarConfig
from gazechair.driving.storing import Storing
from gazechair.first_drive.facts import MOVES, NEUTRALS, STEPS, Facts
from gazechair.first_drive.floor_marks import FloorMarks, marks_of
from gazechair.first_drive.held_button import HeldButton
from gazechair.first_drive.moves import Moves
from gazechair.first_drive.record import Record, fitted_as
from gazechair.people.profiles import Profiles
from gazechair.sensing.lidar.mask import LEAST_SCANS
from gazechair.sensing.lidar.recorded import BEAMS
from gazechair.sensing.lidar.scan import Scan
from gazelink import codes
from gazelink.settings_table import PROFILES, index_of

_MOST_LINES = 40
_MOST_ANSWER = 20
_ANSWER_S = 600.0
_POLL_S = 0.05
_SCANS_S = 30.0
_MOST_MM = 12_000
_READY_S = 10.0  # for the board, from one part of tuning to the next

log = logging.getLogger(__name__)


class StepRefused(Refused):
    """Raised when a step cannot begin or has failed."""


class Steering(Protocol):
    """What this needs from gazechair.driving.control.Control."""

    def stopped_s(self, but: int) -> float: ...
    def press_number(self) -> int: ...
    def owned(self) -> bool: ...


class Guide:
    """Thread-safe: the pages' threads call it, each step runs on its own thread."""

    def __init__(
        self,
        config: Config,
        link: BoardLink,
        parts: HealthRegistry,
        control: Steering,
        profiles: Profiles,
        record: Record,
        remask: Callable[[tuple[LidarConfig, ...]], None],
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
        measured: Measured | None = None,
        keep: Callable[[str, ForwardNumbers], None] = lambda _profile, _numbers: None,
        marks: FloorMarks | None = None,
        step_ms: Callable[[int, int, int], int | None] = lambda *_: None,
    ) -> None:
        """`remask` restarts the lidars with other masks; `wait` sleeps for seconds of `clock`;
        `measured`: odometry's newest estimate, `keep` stores what tuning finds with it, see Tuning;
        `marks`: None without a camera; `step_ms`: see CaretakerSettings."""
        self._config = config
        self._link = link
        self._parts = parts
        self._control = control
        self._profiles = profiles
        self._record = record
        self._remask = remask
        self._clock = clock
        self._wait = wait
        self._measured = measured
        self._keep = keep
        self._marks = marks
        self.held = HeldButton(link, clock, control.stopped_s)
        self.storing = Storing(lambda: control.owned() or bool(self.moving))
        self.settings = CaretakerSettings(link, step_ms, self.storing.store)
        self._lock = threading.Lock()
        self._step = ""  # that runs
        self._lines: deque[str] = deque(maxlen=_MOST_LINES)
        self._pulses = self._straights = 0  # that tuning has begun
        self._ended: dict[str, Any] | None = None
        self._answers: deque[tuple[str, str]] = deque(maxlen=_MOST_LINES)  # question, answer
        self._joystick: JoystickCalibration | None = None
        self._given_up = False
        self._looked = False
        self._clearance: Clearance | None = None
        self._scans: dict[str, list[Scan]] | None = None
        self._drove = False
        self._thread: threading.Thread | None = None

    # For the daemon

    def seen(self, clearance: Clearance) -> Clearance:
        """The clearance to send: during tuning a person watches the areas that no lidar sees."""
        self._clearance = clearance
        return with_eyes(clearance) if self._looked and self.held.alive else clearance

    def scan(self, name: str, acquired_s: float, beams: bytes) -> None:
        """A scan of the lidar `name`, see sensing.lidar.recorded."""
        scans = self._scans
        if scans is not None and name in scans:
            metres = np.frombuffer(beams, "<u2").astype(np.float64) / 1000.0
            angles = (np.arange(BEAMS, dtype=np.float64) + 0.5) * (360.0 / BEAMS) - 180.0
            scans[name].append(Scan(angles, metres, acquired_s, codes.REAL))

    def look(self) -> None:
        """The board has sent something new."""
        state, stats = self._link.state(), self._link.stats()
        if self.moving:
            self.held.tick()
        if not self._drove and state is not None and stats is not None:
            moves = state.state == codes.ARMED and state.motion != codes.STOPPED
            self._drove = moves and stats.counters["owner"] == codes.DRIVER

    def stop(self) -> None:
        """End the running step."""
        self._given_up = True
        self.held.end()
        if self._thread is not None:
            self._thread.join(5.0)

    # For the pages

    @property
    def moving(self) -> str:
        """The step that may move the chair now, "" for none."""
        return self._step if self._step in MOVES else ""

    @property
    def holds_settings(self) -> bool:
        """True while a step measures with the board's settings, to store some of them."""
        return self._step in (*MOVES, "neutral")

    def status(self) -> dict[str, Any]:
        """All steps, and the one that runs or ended last."""
        if self._drove and not self._record.get("drove"):
            self._record.keep("drove", True)
        asks = self._joystick.asks if self._joystick is not None else ""
        run = {
            "step": self._step,
            "lines": list(self._lines),
            "pulses": self._pulses,
            "straight": self._straights,
            "asks": asks,
            "ended": self._ended,
        }
        return {"steps": self._facts().rows(), "run": run}

    def begin(self, step: str, value: Any = None) -> None:
        """Run `step` on its own thread. Raises StepRefused."""
        work = self.prepare(step, value)
        self._thread = threading.Thread(target=work, name="first-drive", daemon=True)
        self._thread.start()

    def prepare(self, step: str, value: Any = None) -> Callable[[], None]:
        """The work of `step`, which counts as running from now on. Raises StepRefused."""
        if step not in STEPS or not hasattr(self, f"_{step}"):
            raise StepRefused("bad_message", f"no step {step!r:.40}")
        reason = self._facts().refused(step)
        if reason:
            raise StepRefused(reason)
        if step in MOVES and not self.held.alive:
            raise StepRefused("first_hold")
        with self._lock:
            if self._step:
                raise StepRefused("first_busy")
            self._step = step
        self._ended = None
        self._given_up = False
        self._lines.clear()
        self._pulses = self._straights = 0
        self._answers.clear()
        return lambda: self._run(step, value)

    def ask(self, request: dict[str, Any]) -> tuple[str, str] | None:
        """{"run": step, "value": ...} begins a step that does not move the chair, {"answer": text,
        "asks": question} is typed input, {"give_up": true} ends the running step. Returns a
        refusal (reason key, detail), or None."""
        step, text, asks = request.get("run"), request.get("answer"), request.get("asks")
        if isinstance(step, str):
            if step in MOVES:
                return "first_hold", "a step that moves the chair begins with its held button"
            try:
                self.begin(step, request.get("value"))
            except StepRefused as refused:
                return refused.reason, str(refused)
        elif isinstance(text, str) and len(text) <= _MOST_ANSWER and isinstance(asks, str):
            self._answers.append((asks, text))
        elif request.get("give_up") is True:
            self._given_up = True
            self.held.end()
        else:
            return "bad_message", "send run, answer with asks, or give_up"
        return None

    # Inside

    def _facts(self) -> Facts:
        link = self._link
        person = str(self._profiles.chosen()["name"]) if self._profiles.kept else ""
        return Facts(
            link.state(),
            link.stats(),
            link.board(),
            self._parts.states(),
            self._clearance,
            self._fitted(),
            self._record,
            person,
            self._marks,
        )

    def _fitted(self) -> tuple[LidarConfig, ...]:
        return tuple(one for one in self._config.lidar if one.kind != "off")

    def _run(self, step: str, value: Any) -> None:
        ended: dict[str, Any] = {"step": step, "ok": True, "reason": "", "detail": ""}
        try:
            getattr(self, f"_{step}")(value)
        except SettingRefused as refused:
            reason = str(codes.reason_name(refused.reason))
            ended |= {"ok": False, "reason": reason, "detail": str(refused)}
        except StepRefused as refused:
            ended |= {"ok": False, "reason": refused.reason, "detail": str(refused)}
        except UserError as error:
            let_go = isinstance(error, StoppedError)
            ended |= {"ok": False, "reason": "first_let_go" if let_go else "first_failed"}
            ended |= {"detail": str(error), "error": error.key, "fields": error.fields}
        except Exception as error:
            log.exception("the first drive's step %s", step)
            ended |= {"ok": False, "reason": "first_failed", "detail": repr(error)}
        finally:
            if step in MOVES:
                self.held.end()  # a button still pressed must not start another step
            self._looked = False
            self._scans = None
            self._joystick = None
            self._ended = ended
            self._step = ""

    def _aborted(self) -> bool:
        return self._given_up or not self.held.alive

    def _read_line(self) -> str:
        end_s = self._clock() + _ANSWER_S
        asks = "" if self._joystick is None else self._joystick.asks
        while not self._given_up and self._clock() < end_s:
            while self._answers:
                to, text = self._answers.popleft()
                if to == asks:  # a second tap must not answer the next question
                    return text + "\n"
            self._wait(_POLL_S)
        return ""

    # Steps: each raises on failure

    def _mask(self, _: Any) -> None:
        lidars = self._fitted()
        scans: dict[str, list[Scan]] = {one.name: [] for one in lidars}
        self._scans = scans
        end_s = self._clock() + _SCANS_S
        while min(map(len, scans.values())) < LEAST_SCANS and self._clock() < end_s:
            if self._given_up:
                raise StepRefused("first_let_go")
            self._wait(_POLL_S)
        found = {}
        for one in lidars:
            learned = learned_mask(one, scans[one.name], self._config.footprint)
            mask = [list(arc) for arc in learned.mask]
            found[one.name] = {"fitted": fitted_as(one), "mask": mask}
        refused = self._facts().refused("mask")
        if refused:  # somebody drives now: keep the present lidars
            raise StepRefused(refused)
        self._record.keep("mask", found)
        self._remask(self._record.masked(self._config.lidar))

    def _distance(self, measured_mm: Any) -> None:
        if type(measured_mm) is not int or not 0 < measured_mm <= _MOST_MM:
            raise StepRefused("setting_out_of_range")
        seen_mm = None if self._clearance is None else self._clearance.forward_mm
        if seen_mm is None or seen_mm > _MOST_MM:
            raise StepRefused("lidar_lost")
        places = [fitted_as(one) for one in self._record.masked(self._fitted())]
        found = {"measured_mm": measured_mm, "seen_mm": seen_mm, "lidars": places}
        self._record.keep("distance", found)
        if not self._facts().rows()[STEPS.index("distance")]["done"]:
            raise StepRefused("first_apart", f"tape {measured_mm} mm, lidar {seen_mm} mm")

    def _neutral(self, _: Any) -> None:
        board = BoardSettings(self._link)
        self._joystick = JoystickCalibration(
            board, self._lines.append, self._read_line, self._clock, self._wait, self.storing.store
        )
        self._joystick.run()
        values = board.all()
        self._record.keep("neutral", [values[index_of(name)] for name in NEUTRALS])

    def _heading(self, _: Any) -> None:
        BoardSettings(self._link).save_heading()

    def _profile(self, row: Any) -> None:
        try:
            self.settings.change({"profile": row})
        except ChangeRefused as refused:
            raise StepRefused(refused.reason, str(refused)) from None
        self._record.keep("profile", PROFILES[row])

    def _relay(self, _: Any) -> None:
        self._moves().relay()
        self._record.keep("relay", True)

    def _tune(self, _: Any) -> None:
        state = self._link.state()
        if state is None or state.profile is None:
            raise StepRefused("not_connected")

        def record(believed: TurnNumbers, neutral_count: int) -> Sequence[Recording]:
            self._looked = True
            self._wait(PERMITTED_S)
            return Runner(self._hands(), self._pulse_begins).run(believed, neutral_count)

        straight = None if self._measured is None else partial(self._straight, self._measured)
        board, say = BoardSettings(self._link), self._lines.append
        Tuning(board, record, say, lambda: True, straight, self._keep).run(state.profile, False)

    def _straight(self, measured: Measured) -> list[ForwardRecording]:
        end_s = self._clock() + _READY_S
        while (state := self._link.state()) is None or state.state or state.arm_reason:
            if self._clock() > end_s or self._aborted():
                break  # the attempt reports what blocks it
            self._wait(_POLL_S)
        return ForwardRunner(self._hands(), measured, self._straight_begins).run()

    def _pulse_begins(self) -> None:
        self._pulses += 1

    def _straight_begins(self) -> None:
        self._straights += 1

    def _turn(self, _: Any) -> None:
        state = self._link.state()
        if state is None or state.step_deg is None:
            raise StepRefused("not_connected")
        turned = [round(one, 1) for one in self._moves().turns()]
        profile = [state.profile, state.tuned]
        found = {"profile": profile, "turned_deg": turned, "wanted_deg": state.step_deg}
        self._record.keep("turn", found)

    def _camera(self, value: Any) -> None:
        marks = marks_of(value)
        if marks is None or self._marks is None:
            raise StepRefused("setting_out_of_range")
        self._marks.fit(marks)

    def _moves(self) -> Moves:
        return Moves(self._hands(), self._link.stats)

    def _hands(self) -> Hands:
        numbers, say = self._control.press_number, self._lines.append
        return Hands(self.held, self._clock, self._wait, self._aborted, say, numbers)
