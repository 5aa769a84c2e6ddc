"""Guides a person through tuning one speed profile, and stores what was found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from gazechair.commissioning.board_settings import SettingsError, may_be_done
from gazechair.commissioning.tune import StoppedError, TuneError
from gazechair.commissioning.tune.forward import ForwardNumbers, ForwardRecording
from gazechair.commissioning.tune.forward import identify as identify_straight
from gazechair.commissioning.tune.forward_rows import straight_lines, straight_rows
from gazechair.commissioning.tune.identify import Fit, identify
from gazechair.commissioning.tune.judge import fits_profile, judge
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazelink.settings_table import PROFILES, index_of, profile_row

_BEFORE = """\
Tuning profile {profile}: the chair turns left and right by itself, ten short pulses within some
25 degrees to each side, about half a minute; it ends where it began.
  - Select profile {profile} on the chair. Somebody sits in it as on any day, or a like weight.
  - An even, firm floor; a metre free all round. Check the area behind the chair first: the lidar
    may not see it. Nobody touches the chair.
  - Any key or Ctrl-C stops it at once. So do the emergency button and every other stop."""
_STRAIGHT = """\
Then it drives straight on three times, two metres in all at most: leave three metres free ahead."""
_ROWS = (
    ("left_q4_dps", "left, full deflection", "deg/s", 16),
    ("right_q4_dps", "right, full deflection", "deg/s", 16),
    ("deadband_permille", "deadband", "%", 10),
    ("dead_time_ms", "dead time", "ms", 1),
    ("lag_ms", "lag", "ms", 1),
    ("accelerate_dps2", "speeds up", "deg/s2", 1),
    ("brake_dps2", "slows down", "deg/s2", 1),
    ("breakaway_q4_dps", "breaks loose at", "deg/s", 16),
)


class Board(Protocol):
    """What this needs from board_settings.BoardSettings."""

    def all(self) -> list[int]:
        """The values in force."""

    def set(self, index: int, value: int) -> None:
        """Set a value, not saved yet."""

    def save(self, values: Mapping[int, int]) -> None:
        """Save the values in force to the board's flash; `values` must still be."""


class Tuning:
    """One tuning. `record` runs the pulses (see runner.Runner.run); `say` gets each line."""

    def __init__(
        self,
        board: Board,
        record: Callable[[TurnNumbers, int], Sequence[Recording]],
        say: Callable[[str], None],
        confirm: Callable[[], bool],
        straight: Callable[[], Sequence[ForwardRecording]] | None = None,
        keep: Callable[[str, ForwardNumbers], None] = lambda _profile, _numbers: None,
    ) -> None:
        """`confirm`: True if the person has read the explanation and agrees; `straight` runs the
        straight presses (see forward_runner.ForwardRunner.run), None: nothing measures them;
        `keep` stores their result, and raises OSError if it cannot."""
        self._board = board
        self._record = record
        self._say = say
        self._confirm = confirm
        self._straight = straight
        self._keep = keep
        self._found: ForwardNumbers | None = None

    def run(self, profile: str, dry_run: bool) -> None:
        """Tune `profile` (of settings_table.PROFILES). Raises TuneError or SettingsError with the
        reason, and then changes nothing, nor when it is interrupted."""
        before = self._board.all()
        self._say(_BEFORE.format(profile=profile))
        if self._straight is not None:
            self._say(_STRAIGHT)
        if not self._confirm():
            raise TuneError("nobody said go; nothing was changed", "tune_no_go")
        believed = TurnNumbers.default(profile)
        recordings = self._record(believed, before[index_of("neutral_turn_count")])
        fit = identify(recordings, believed)
        judge(recordings, fit)
        fits_profile(fit.numbers, profile)
        rows = fit.numbers.rows(profile)
        self._show(profile, before, rows, fit)
        rows |= self._straight_rows(profile, before, fit.numbers)
        if dry_run:
            self._say("dry run: nothing was changed")
            return
        self._store(before, rows | {"profile": PROFILES.index(profile)})
        if self._found is not None:
            try:
                self._keep(profile, self._found)
            except (OSError, KeyboardInterrupt) as error:
                why = str(error) or "stopped"
                self._say(f"a change of the profile does not change the step: {why}")
        self._say(f"stored; the board now drives with profile {profile}")

    def _show(self, profile: str, before: Sequence[int], rows: dict[str, int], fit: Fit) -> None:
        row = PROFILES.index(profile)
        self._say(f"{'':<24}{'before':>10}{'found':>10}")
        for name, words, unit, per in _ROWS:
            setting = profile_row(row, name)
            old, new = before[index_of(setting)] / per, rows[setting] / per
            self._say(f"{words:<24}{old:>10.1f}{new:>10.1f} {unit}")
        self._say(f"the chair's turns are explained to within {fit.residual_deg:.2f} degrees")

    def _straight_rows(
        self, profile: str, before: Sequence[int], turns: TurnNumbers
    ) -> dict[str, int]:
        """{setting: value} for driving straight; empty when it could not be measured."""
        row = PROFILES.index(profile)
        brake = before[index_of(profile_row(row, "brake_mm_s2"))]
        why = "it cannot be measured here"
        try:
            if self._straight is not None:
                found = identify_straight(self._straight())
                rows = straight_rows(found, profile, before, turns)
                for line in straight_lines(found, rows, before, profile):
                    self._say(line)
                self._found = found
                return rows
        except StoppedError:
            raise
        except TuneError as error:
            why = str(error)
        self._say(f"braking while driving forward stays {brake} mm/s2: {why}")
        return {}

    def _store(self, before: Sequence[int], rows: dict[str, int]) -> None:
        # The flag "tuned" is cleared first and set last, here and when undone: if this ends
        # halfway, the profile counts as not tuned.
        values = {index_of(name): value for name, value in rows.items()}
        tuned = index_of(profile_row(rows["profile"], "tuned"))
        changed = [tuned]
        saving = False
        try:
            for index, value in ((tuned, 0), *_last(tuned, values)):
                changed.append(index)  # perhaps only the answer was lost
                self._board.set(index, value)
            saving = True
            self._board.save(values)
        except BaseException as error:  # Ctrl-C, too, leaves nothing half stored
            expected = isinstance(error, SettingsError)
            why = str(error) if expected else "stopped"
            old = {index: before[index] for index in changed}
            self._put_back(tuned, old, saving and may_be_done(error), why)
            if not expected:
                raise
            text = "not stored: {error}; the settings are as before"
            raise TuneError(text, "store_failed", error=why) from None

    def _put_back(self, tuned: int, old: dict[int, int], save: bool, why: str) -> None:
        try:
            for index, value in ((tuned, 0), *_last(tuned, old)):
                self._board.set(index, value)
            if save:
                self._board.save(old)
        except (SettingsError, KeyboardInterrupt):
            raise TuneError(
                "not stored ({error}), and what was changed could not be put back; switch the"
                " board off and on, it then starts with what it saved",
                "store_lost",
                error=why,
            ) from None


def _last(index: int, values: dict[int, int]) -> list[tuple[int, int]]:
    """All of `values`, the one of `index` last."""
    return [*((at, values[at]) for at in values if at != index), (index, values[index])]
