"""The error handler: reduces all current problems to one level and one message for people."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from gazechair.base.health import HealthState
from gazechair.base.reasons import NOTE, PARTS, REASONS, SHOWN
from gazechair.board.state import BoardState
from gazelink import codes

LEVELS = {0: "ok", codes.WARNING: "warning", codes.ERROR: "error"}

# {(part, health state): severity}
_SEVERITIES = {
    (name, state): severity
    for name, part in SHOWN.items()
    for state, severity in part.severity.items()
}

# {what the board sees: how the keys of its causes begin}. Often the board is the first to see it.
_EFFECTS = {"obstacle_data_old": "lidar_"}


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong."""

    key: str
    """A key of the string tables."""
    severity: int
    """codes.WARNING or codes.ERROR."""
    caretaker_only: bool = False
    """Not shown to the driver."""
    about: str = ""
    """See HealthState."""


@dataclass(frozen=True)
class Verdict:
    """What the page's corner shows."""

    level: str
    """ "ok", "warning" or "error"."""
    message: str
    """A key of the string tables, "ok" when nothing is wrong."""
    about: str = ""
    """See HealthState."""


def of_board(state: BoardState) -> list[Problem]:
    """The board's fault bits, and the override while a command is overruled."""
    problems = [
        Problem(name, severity)
        for bit, name, severity, _latched in codes.FAULTS
        if state.faults >> bit & 1
    ]
    if state.override != codes.NO_REASON:
        problems.append(Problem(state.override_name, codes.WARNING))
    if state.tuned is False:
        problems.append(Problem("untuned", NOTE))  # shown if everything else is OK
    return problems


def of_parts(parts: dict[str, HealthState]) -> list[Problem]:
    """The problems that follow from the parts' health."""
    return [
        Problem(part.reason, _SEVERITIES[name, part.state], SHOWN[name].caretaker_only, part.about)
        for name, part in parts.items()
        if (name, part.state) in _SEVERITIES
        and (part.reason not in REASONS or REASONS[part.reason].severity > NOTE)
    ]


def of_silence(part: str, age_s: float | None) -> list[Problem]:
    """A source that has become silent; `age_s`: of its newest data, None: never any."""
    if age_s is None or age_s <= PARTS[part].silent_s:
        return []
    key = f"{part}_lost"
    return [Problem(key, REASONS[key].severity)]


def of_host(
    parts: dict[str, HealthState],
    state: BoardState | None,
    lidar_age_s: float | None,
    camera_age_s: float | None,
    page_silent: bool,
) -> list[Problem]:
    """All but those that follow from another. Ages: of the newest data, None: never any."""
    problems = of_parts(parts)
    if state is not None:
        problems += of_board(state)
    problems += of_silence("lidar", lidar_age_s)
    problems += of_silence("camera", camera_age_s)
    if page_silent:
        problems.append(Problem("page_silent", codes.WARNING))
    errors = [problem.key for problem in problems if problem.severity == codes.ERROR]
    follow = {key for key, cause in _EFFECTS.items() if any(e.startswith(cause) for e in errors)}
    return [problem for problem in problems if problem.key not in follow]


class ErrorHandler:
    """Remembers when each problem began; shows the most severe, then the oldest."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}

    def fold(self, problems: Iterable[Problem], now_s: float) -> Verdict:
        """The verdict on all problems at `now_s`, monotonic seconds."""
        severities: dict[str, int] = {}
        abouts: dict[str, str] = {}
        for problem in problems:
            abouts[problem.key] = abouts.get(problem.key) or problem.about
            known = severities.get(problem.key, 0)
            severities[problem.key] = max(known, problem.severity)
        self._since_s = {key: self._since_s.get(key, now_s) for key in severities}
        if not severities:
            return Verdict("ok", "ok")
        worst = min(severities, key=lambda key: (-severities[key], self._since_s[key]))
        return Verdict(LEVELS[severities[worst]], worst, abouts[worst])
