"""What the fuzzer put in, as the promises count it: sessions, commands, orders, obstacles.

The oracle's memory (fuzz_oracle judges by it). Only honest frames count, and only in their order:
everything else must come to nothing (P12). Times are microseconds of the world's clock.
"""

from __future__ import annotations

from typing import NamedTuple

from gazelink import codes, messages
from gazeprove.fuzz_board import World
from gazeprove.fuzz_chair import Chair
from gazeprove.fuzz_host import Sent
from gazeprove.fuzz_rules import Rules

MS = 1000
_STORED_TICKS = 10  # a slice of the service loop, and the flash
_DISTANCES = ("forward_mm", "backward_mm", "left_q4_deg", "right_q4_deg")
_MOVES = frozenset((codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE))


class Violation(Exception):
    """A promise was broken. `promise` is its number in the table."""

    def __init__(self, promise: str, text: str) -> None:
        super().__init__(f"{promise}: {text}")
        self.promise = promise


class Output(NamedTuple):
    """One tick's outputs, for what the board reports of them later."""

    linear: int
    turn: int
    rising: bool  # the enable line went high
    toggled: bool
    failed: bool
    emergency: bool  # latched two ticks ago already
    overruled: bool  # a held press stands still for a cause that must be told


class Facts:
    """One board's life after another, in one world."""

    def __init__(self, world: World, chair: Chair) -> None:
        self.world = world
        self.chair = chair
        self.rules = Rules()
        self.latched: set[str] = set()
        self.emergency_kept = True  # what the board stored of it is still there
        self.tick_count = 0
        self.emergency_stored_at = 0  # a reset before that tick may come before it was stored
        self.stats: dict[str, int] = {}
        self.past: dict[int, Output] = {}  # the last ticks by number
        self.boot()

    def boot(self) -> None:
        """The board has just come up: nothing of before counts."""
        now = self.world.now_us
        stored = self.emergency_kept and self.tick_count >= self.emergency_stored_at
        self.emergency_stored_at = 0
        self.tick_count = 0
        self.emergency_at = 50  # one that is known from before is reported by then
        self.latched = {"P11"} & self.latched if stored else set()
        self.rules.boot()
        self.last_tick_us = now
        self.slow_us = -(1 << 60)  # when ticks last came at another pace than 1 ms
        self.period_us = 1000
        self.service_us = now
        self.toggled_at = -100
        self.unverified = 0
        self.writes = 0  # the last three, a bit each: failed
        self.unseen_us = 0  # of motion since the heading sensor tells nothing
        self.steep = False  # it stood askew by half the limit when it was last seen
        self.flaky_us = -1  # since when two of three fail
        self.paced = True  # every tick of this boot came in its millisecond
        self.failed_us = now
        self.wipers = (0, 0)
        self.moved_us = now  # when the wipers last changed or were not neutral
        self.button_us = -1
        self.open_us = -1
        self.enabled_at = -1
        self.enabled_us = 0
        self.off_at = -1
        self.off_why = ""
        self._forget_session(None)
        if self.world.enable:
            raise Violation("P1", "the enable line is on at boot")

    def _forget_session(self, session: object) -> None:
        self.session = session
        self._last_index = 0
        self.host_us = self.world.now_us
        self.commands: dict[int, Sent] = {}
        self.dead: set[int] = set()
        self.owner = codes.NOBODY
        self.former = (codes.NOBODY, -1)  # the owner before, until that tick
        self.arms: list[tuple[int, int]] = []  # (tick, owner)
        self._numbers: set[int] = set()
        self.seen_us = -(1 << 60)
        self.source = -1
        self.blocked_at = [-1] * 4
        self.arcs_at = -1  # since then no way of both axes at once is free
        self.unseen_at = [-1] * 4
        self.arcs_unseen_at = -1  # since then both axes at once enter what no lidar sees
        self.bypass_us = -1  # since when it is held
        self.bypass_number = -1
        self.watched = (0, -(1 << 60))  # the press that somebody watches, and when that was seen
        self.waits_us = -1  # since when an obstacle overrules an auto motion
        self.bypass_until_us = -(1 << 60)
        self.command_us = -(1 << 60)
        self.step = (0, 0)  # press, since when it moves
        self.turning_us = -1
        self.overruled = (0, 0)  # the press that a cause has ended, since that tick
        self.past.clear()

    # -- what went in --------------------------------------------------------------------------

    def served(self, taken: list[Sent]) -> None:
        """The service loop ran and has read these frames to their end."""
        self.service_us = self.world.now_us
        silent_us = self.world.now_us - self.host_us
        self._doubtful = silent_us > 480 * MS  # the board may have ended the session already
        if self.session is not None and silent_us > self.late(500, self.world.now_us):
            self.session = None  # P12: what a host said before so long a silence counts no more
        for sent in taken:
            if sent.message is messages.HELLO:
                self._hello(sent)
            elif not sent.spoilt and sent.session == self.session and self.session is not None:
                self._honest(sent)

    def _hello(self, sent: Sent) -> None:
        if sent.spoilt and sent.spoilt != "replayed":
            return
        number = sent.fields["session"]
        if self.session is None or number != self.session[0]:  # type: ignore[index]
            self.fall("P14", "a new session", self.tick_count + 1)
            self._forget_session((number, self.boot_id))
            self.rules.session()

    boot_id = 0

    def _honest(self, sent: Sent) -> None:
        now = self.world.now_us
        if sent.index <= self._last_index:
            return
        self._last_index = sent.index
        fresh = now - sent.born_us <= 100 * MS
        if fresh:
            self.host_us = now
        if sent.message is messages.COMMAND:
            self._on_command(sent, fresh)
        elif sent.message is messages.ORDER:
            self._on_order(sent.fields, fresh)
        elif sent.message is messages.CLEARANCE:
            self._on_clearance(sent)
        elif sent.message is messages.BYPASS and fresh:
            self._on_bypass(sent)
        elif sent.message is messages.SUPERVISION and fresh:
            if sent.fields["owner"] in (codes.DRIVER, codes.CARETAKER):
                seen_us = sent.born_us - sent.fields["age_ms"] * MS
                self.watched = (sent.fields["edge"], seen_us)
        elif sent.message is messages.SETTING:
            self.rules.requested(sent.fields)

    def _on_command(self, sent: Sent, fresh: bool) -> None:
        now = self.world.now_us
        fields = sent.fields
        if fields["verb"] == codes.STOP:
            for command in self.commands.values():
                self.dead.add(command.press)
            self.commands.clear()
            self.overruled = (0, 0)
            self.command_us = min(self.command_us, now)
            return
        if not fresh or not _possible(fields):
            return
        self._pressed(sent.press)
        if self.enabled_at < 0:
            self.dead.add(sent.press)  # pressed before it was armed
        if fields["ttl_ms"] > 0:
            self.command_us = max(self.command_us, sent.born_us + min(300, fields["ttl_ms"]) * MS)
        old = self.commands.get(fields["owner"])
        if old is not None and old.press != sent.press:
            self.dead.add(old.press)
        if old is not None and old.press == sent.press and not _same_press(old, sent):
            self.dead.add(sent.press)
        self.commands[fields["owner"]] = sent

    def _pressed(self, press: int) -> None:
        """Any press ends an auto motion (P20)."""
        for command in self.commands.values():
            if command.fields["mode"] == codes.AUTO and command.press != press:
                self.dead.add(command.press)
                self.count("P20")

    def _on_order(self, fields: dict[str, int], fresh: bool) -> None:
        action, owner, number = fields["action"], fields["owner"], fields["number"]
        if action > codes.RESET_FAULTS or number == 0:
            return
        if action == codes.EMERGENCY_STOP and self._doubtful:
            return
        if action == codes.EMERGENCY_STOP:
            self._numbers.add(number)
            self.emergency()
            self.fall("P11", "an emergency message", self.tick_count + 2)
            return
        if number in self._numbers:
            return
        if action == codes.DISARM:
            self._numbers.add(number)
            self.fall("P13", "an order to disarm", self.tick_count + 1)
        elif fresh:
            self._numbers.add(number)
            if action == codes.RESET_FAULTS and owner == codes.CARETAKER:
                self.reset()
            elif action == codes.ARM and owner in (codes.DRIVER, codes.CARETAKER):
                self._on_arm(owner)

    def _on_arm(self, owner: int) -> None:
        if self.enabled_at < 0 or self.off_at >= 0:
            self.arms.append((self.tick_count, owner))
        elif owner != self.owner:
            self.former = (self.owner, self.tick_count + 1)
            self.owner = owner
            for command in self.commands.values():
                self.dead.add(command.press)

    def emergency(self) -> None:
        """Latched from now on."""
        if "P11" not in self.latched:
            self.latched.add("P11")
            self.emergency_at = self.tick_count
            self.emergency_stored_at = self.tick_count + _STORED_TICKS

    def reset(self) -> None:
        """Somebody who may has reset the faults."""
        emergency = self.world.emergency_level == 1
        self.latched = {"P11"} & self.latched if emergency else set()

    def _on_clearance(self, sent: Sent) -> None:
        fields = sent.fields
        if fields["source"] > codes.REPLAYED:
            return
        self.seen_us = sent.born_us - fields["age_ms"] * MS
        self.source = fields["source"]
        rules = self.rules
        margins = (rules.stop_margin_mm,) * 2 + (rules.stop_margin_q4_deg,) * 2
        for way in range(4):
            near = fields[_DISTANCES[way]] < margins[way]
            if not near and not fields["blocked"] >> way & 1:
                self.blocked_at[way] = -1
            elif self.blocked_at[way] < 0:
                self.blocked_at[way] = self.tick_count
            if not fields["unseen"] >> way & 1:
                self.unseen_at[way] = -1
            elif self.unseen_at[way] < 0:
                self.unseen_at[way] = self.tick_count
        if fields["arc_views"] >> 4 != 15:
            self.arcs_unseen_at = -1
        elif self.arcs_unseen_at < 0:
            self.arcs_unseen_at = self.tick_count
        if any(fields["arcs"]) and fields["arc_views"] & 15 != 15:
            self.arcs_at = -1
        elif self.arcs_at < 0:
            self.arcs_at = self.tick_count

    def _on_bypass(self, sent: Sent) -> None:
        now = self.world.now_us
        if sent.fields["number"] != self.bypass_number:
            self.bypass_number = sent.fields["number"]
            self._pressed(0)
        # Other numbers in between make no new time; a short bypass takes a short pause. The board's
        # own may have begun before this one's does: it was not pressed while it was not armed.
        pause_us = max(900_000, (self.bypass_until_us - self.bypass_us) // 2 - 400_000)
        if now - self.bypass_until_us > min(5_000_000, pause_us):
            self.bypass_us = now
        self.bypass_until_us = sent.born_us + min(300, sent.fields["ttl_ms"]) * MS

    # -- what follows

    def late(self, limit_ms: int, now: int) -> int:
        """A limit by the world's clock: ages may run slow by 5 % when ticks do."""
        if now - self.slow_us > 2_000_000:
            return limit_ms * MS
        return limit_ms * 1050 + self.period_us

    def lasted(self, limit_ms: int, now: int) -> int:
        """The same of a step's time, in which all that passes without ticks counts but 0.5 %."""
        if now - self.slow_us > 2_000_000:
            return limit_ms * MS
        return limit_ms * 1005 + self.period_us

    def fall(self, promise: str, why: str, at: int) -> None:
        """The chair is disarmed by this; the enable line may not change in tick `at` or later."""
        self.arms.clear()
        for command in self.commands.values():
            self.dead.add(command.press)
        if self.enabled_at >= 0 and (self.off_at < 0 or at < self.off_at):
            self.off_at = at
            self.off_why = f"{promise}: enable line on after {why}"
            self.count(promise)

    def count(self, what: str) -> None:
        self.stats[what] = self.stats.get(what, 0) + 1


def _possible(fields: dict[str, int]) -> bool:
    return (
        fields["verb"] in _MOVES
        and fields["mode"] <= codes.AUTO
        and fields["edge"] != 0
        and abs(fields["linear_permille"]) <= 1000
        and abs(fields["turn_permille"]) <= 1000
        and fields["cap_permille"] <= 1000
    )


def _same_press(old: Sent, new: Sent) -> bool:
    return all(old.fields[name] == new.fields[name] for name in ("verb", "mode"))
