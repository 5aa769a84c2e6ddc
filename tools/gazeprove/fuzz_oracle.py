"""The safety promises as an oracle over the whole board: what goes out, judged by what went in.

Written from the promises' text (docs/safety.md). It sees the wipers' registers, the enable line and
what the fuzzer itself did, with times; never an attribute of the firmware. Times are microseconds
of the world's clock; `tick` counts ticks since the board's boot.
"""

from __future__ import annotations

from gazelink import codes
from gazeprove.fuzz_auto_facts import AutoFacts
from gazeprove.fuzz_facts import MS, Output, Violation
from gazeprove.fuzz_host import Sent

_FORWARD, _BACKWARD, _LEFT, _RIGHT = range(4)
_WAY_OF = {
    codes.FORWARD: _FORWARD,
    codes.BACKWARD: _BACKWARD,
    codes.LEFT: _LEFT,
    codes.RIGHT: _RIGHT,
}
_SPAN = 84
# From its mode that measures to its first data, with a sample; until then the tilt is not known.
_SENSOR_STARTS_US = 130 * MS
_EXPLAINED = frozenset(("P5", "P6", "P7", "P16"))  # the reason is sent back


class Oracle(AutoFacts):
    """Judges each tick. Raises Violation."""

    # -- what came out -------------------------------------------------------------------------

    def ticked(self, linear: int, turn: int, toggled: bool, failed: bool, raised: bool) -> None:
        """After each tick: the wipers, whether the enable line changed, what the tick met."""
        world = self.world
        now = world.now_us
        at = self.tick_count = self.tick_count + 1
        gap_us = now - self.last_tick_us
        self.last_tick_us = now
        if gap_us != 1000:
            self.paced = False
        if gap_us > 1005:
            self.slow_us = now
            self.period_us = gap_us
        if gap_us > 20 * MS:
            self.fall("P10", f"a tick {gap_us} us late", at)
        if raised:
            self.paced = False  # the board does not count this one
            self.latched.add("P10")
            self.fall("P10", "an exception in the tick", at)
        if world.emergency_level:
            self.emergency()
            self.fall("P11", "the emergency input", at + 1)
        self._button(now)
        self.unverified = self.unverified + 1 if failed else 0
        if failed:
            self.failed_us = now
            if self.unverified >= 3:
                self.latched.add("P8")
                self.fall("P8", "three failed writes", at + 1)
        self.writes = self.writes << 1 & 7 | failed
        if self.writes not in (3, 5, 6, 7):
            self.flaky_us = -1
        elif self.flaky_us < 0:
            self.flaky_us = now
        elif now - self.flaky_us > self.late(1050, now):
            self.latched.add("P8")
            self.fall("P8", "two of three writes failing for a second", at + 1)
        if self.enabled_at >= 0:
            self._judge_silence(now, at)
        if toggled:
            self._judge_enable(now, at, failed)
        elif at - self.toggled_at > 3:
            self._enable_ended()
        neutral = self.rules.neutral
        moving = linear != neutral[0] or turn != neutral[1]
        if (linear, turn) != self.wipers:
            self.wipers = (linear, turn)
            self.moved_us = now
            if moving and self.enabled_at < 0 and self.wipers in self.rules.neutrals:
                moving = False  # a neutral that is being set
        elif moving and self.enabled_at < 0 and self.wipers in self.rules.neutrals:
            moving = False
        self._watch_sensor(gap_us, moving)
        if failed:
            moving = False  # what the wipers do is out of the board's hands
        if moving or self.commands:
            self._judge_motion(now, at, linear - neutral[0], turn - neutral[1], moving)
        self._remember(at, toggled, failed)

    def _enable_ended(self) -> None:
        if self.world.enable:
            raise Violation("P10", "the enable line rests at its high level")
        if self.enabled_at >= 0:
            self.enabled_at = -1
            self.owner = codes.NOBODY
            for command in self.commands.values():
                self.dead.add(command.press)
        self.off_at = -1

    def _remember(self, at: int, toggled: bool, failed: bool) -> None:
        linear, turn = self.wipers
        press, since = self.overruled
        overruled = press != 0 and at >= since + 3
        emergency = "P11" in self.latched and at >= self.emergency_at + 2
        rising = toggled and self.world.enable == 1
        past = self.past
        past[at] = Output(linear, turn, rising, toggled, failed, emergency, overruled)
        past.pop(at - 300, None)

    def reported(self, stamp: int, fields: dict[str, int]) -> None:
        """A STATE frame: what the board says about itself must be so."""
        at = self.tick_count - ((self.tick_count - stamp) & 0xFFFF)
        past = self.past.get(at) if self.paced else None
        if past is None:
            return
        reported = (fields["linear_permille"], fields["turn_permille"])
        neutrals = [self.rules.neutral]
        if self.enabled_at < 0:
            neutrals += self.rules.neutrals  # being set
        if not past.failed and not any(
            reported == (_permille(past.linear - linear), _permille(past.turn - turn))
            for linear, turn in neutrals
        ):
            raise Violation("telemetry", f"says {reported} permille at {past.linear} {past.turn}")
        disarmed = fields["status"] & 15 == codes.DISARMED
        if disarmed and past.rising:
            raise Violation("telemetry", "says disarmed while the enable line goes on")
        if past.emergency and not fields["faults"] >> codes.EMERGENCY & 1:
            raise Violation("P11", "the emergency is not reported")
        if past.overruled and not fields["override"]:
            raise Violation("P5", "a held press stands still and no reason is sent back")

    def _button(self, now: int) -> None:
        if self.world.button_level:
            self.button_us = -1
        elif self.button_us < 0:
            self.button_us = now
        elif now - self.button_us >= 2990 * MS and self.latched:
            self.reset()

    def _judge_silence(self, now: int, at: int) -> None:
        if now - self.host_us > self.late(500, now):
            self.fall("P2", "500 ms without a host", at)
        if now - self.service_us > self.late(500, now):
            self.fall("P9", "500 ms without the service loop", at)
        turned_us = self.chair.turned_us
        if turned_us >= 0 and now - max(turned_us, self.moved_us) > 3_000_000 and self._senses():
            self.latched.add("P21")
            self.fall("P21", "3 s of turning with neutral put out", at)
        if self.rules.relay_fitted and now - self.enabled_us > 200 * MS:
            if self.world.relay_closed:
                self.open_us = -1
            elif self.open_us < 0:
                self.open_us = now
            elif now - self.open_us > self.late(30, now):
                self.fall("arming", "30 ms of an open relay", at)

    def _judge_enable(self, now: int, at: int, failed: bool) -> None:
        self.toggled_at = at
        if not self.world.enable:
            return  # a last fall is how it ends
        if failed:
            raise Violation("P8", "the enable line changed though a wiper write was not verified")
        if self.enabled_at >= 0 and self.off_at >= 0 and at >= self.off_at:
            raise Violation(self.off_why.partition(":")[0], self.off_why)
        if self.enabled_at < 0:
            self._judge_arming(now, at)
            self.enabled_at = at
            self.enabled_us = now
            self.open_us = -1
            self.count("armings")

    def _judge_arming(self, now: int, at: int) -> None:
        world = self.world
        given = [owner for tick, owner in self.arms if tick >= at - 3]
        self.arms.clear()
        if not given:
            raise Violation("P14", "the enable line is on without an order to arm")
        self.owner = given[-1]
        if len(given) > 1 and given[-2] != given[-1]:
            self.former = (given[0], at + 1000)
        for promise in sorted(self.latched):
            raise Violation(promise, "armed with a latched fault that nobody has reset")
        missing = [
            (world.emergency_level == 1, "P11", "the emergency input open"),
            (self.rules.relay_fitted and world.relay_closed, "arming", "the relay closed"),
            (now - self.seen_us > self.late(300, now), "P6", "old obstacle data"),
            (now - self.host_us > self.late(100, now), "P2", "a silent host"),
            (now - self.failed_us < 499 * MS, "P8", "neutral not read back for 500 ms"),
            (now - self.moved_us < 499 * MS, "arming", "wipers not at rest for 500 ms"),
            (now - self.command_us < 295 * MS, "arming", "a command within 300 ms"),
            (self.source != codes.REAL and not world.simulated, "arming", "no real lidar"),
            (not self.rules.calibrated, "arming", "damaged settings"),
            (not self.rules.neutral_stored, "arming", "a neutral that is not stored"),
            (self._tilted(now), "P16", "the chair tilted"),
            (self._no_heading(now), "P7", "no heading"),
        ]
        for is_so, promise, what in missing:
            if is_so:
                raise Violation(promise, f"armed with {what}")

    def _judge_motion(self, now: int, at: int, linear: int, turn: int, moving: bool) -> None:
        command = self.commands.get(self.owner)
        if turn == 0:
            self.turning_us = -1
        elif self.turning_us < 0:
            self.turning_us = now
        if moving:
            self.moved_us = now
            if self.enabled_at < 0 or at - self.enabled_at < 50:
                raise Violation("P1", f"motion {linear} {turn} while not armed for 50 ms")
            former = self.former
            if at <= former[1] and (command is None or command.press in self.dead):
                command = self.commands.get(former[0]) or command
                if command is not None and former[1] > at + 1:
                    self.owner = former[0]
        if command is None:
            self.overruled = (0, 0)
            if moving:
                raise Violation("P13", f"motion {linear} {turn} after a stop, or nobody's")
            return
        press = command.press
        cause = self._cause(command, now, at, linear, turn)
        if moving or not cause:
            self.waits_us = -1
        if moving:
            if cause:
                raise Violation(cause.partition(":")[0], cause)
            if press in self.dead:
                raise Violation("P14", f"press {press} moves again")
            self._judge_size(command.fields, linear, turn, now)
            self.count("moving")
            if command.fields["mode"] == codes.AUTO:
                self.count("auto")
            if self.step[0] != press:
                self.step = (press, now)
                self.count(codes.VERBS[command.fields["verb"]])
        elif cause and self._waits(command, cause, now):
            self.count(cause.partition(":")[0])
        elif cause and press not in self.dead:
            promise = cause.partition(":")[0]
            if self.step[0] == press:
                self.count(promise)
                if promise in _EXPLAINED:
                    self.overruled = (press, at)
            self.dead.add(press)
        if self.overruled[0] != press or moving:
            self.overruled = (0, 0)

    def _cause(self, command: Sent, now: int, at: int, linear: int, turn: int) -> str:
        """Why this command may not move the chair now; "" when it may."""
        fields = command.fields
        if now - self.host_us > self.late(100, now):
            return "P2: no host for 100 ms"
        if now - self.service_us > self.late(50, now):
            return "P9: no service loop for 50 ms"
        if now - self.seen_us > self.late(300, now):
            return "P6: obstacle data older than 300 ms"
        if self._tilted(now):
            return "P16: tilted for 100 ms"
        verb, mode = fields["verb"], fields["mode"]
        stepping = mode == codes.STEP and verb != codes.DRIVE
        moved = self.step[0] == command.press
        if not stepping or not moved:
            longest = 150 if mode == codes.AUTO else 300
            lives_us = min(longest, fields["ttl_ms"]) * MS
            if now - command.born_us > self._stretch(lives_us, now):
                promise = "P17" if mode == codes.AUTO else "P3"
                return f"{promise}: the command is older than its time to live"
        if mode == codes.AUTO:
            cause = self._auto_ends(command, moved, now)
            if cause:
                return cause
        if moved and mode != codes.CONTINUOUS and verb != codes.DRIVE:
            limit_ms = self._limit_ms(verb, mode, fields)
            if now - self.step[1] > self.lasted(limit_ms + 1, now):
                return f"P4: longer than {limit_ms} ms"
        return self._on_the_way(fields, now, at, linear, turn)

    def _limit_ms(self, verb: int, mode: int, fields: dict[str, int]) -> int:
        if mode == codes.TUNE:
            return min(2000, fields["pulse_ms"])
        if verb in (codes.FORWARD, codes.BACKWARD):
            return self.rules.step_forward_ms
        return self.rules.step_turn_limit_ms

    def _on_the_way(self, fields: dict[str, int], now: int, at: int, linear: int, turn: int) -> str:
        verb, auto = fields["verb"], fields["mode"] == codes.AUTO
        bypassed = not auto and self._bypassed(now)
        turns = verb in (codes.LEFT, codes.RIGHT) or turn != 0
        ways = [_WAY_OF[verb]] if verb in _WAY_OF and not (linear or turn) else []
        if auto and not (linear or turn):  # it waits, for what it asks
            linear, turn = fields["linear_permille"], fields["turn_permille"]
        if linear:
            ways.append(_FORWARD if linear > 0 else _BACKWARD)
        if turn and verb not in (codes.FORWARD, codes.BACKWARD) and not linear:
            ways.append(_LEFT if turn > 0 else _RIGHT)
        if linear and turn and verb == codes.DRIVE:
            ways = []
            if 0 <= self.arcs_at <= at - 2 and not bypassed:
                return "P5: no way of both axes at once"
            if auto and 0 <= self.arcs_unseen_at <= at - 2:
                return "P19: both axes where no lidar sees"
        for way in ways:
            since = self.blocked_at[way]
            if auto and 0 <= self.unseen_at[way] <= at - 2:
                return f"P19: {codes.DIRECTIONS[way]} where no lidar sees"
            if since >= 0 and at >= since + 2 and not bypassed:
                return f"P5: {codes.DIRECTIONS[way]} blocked"
        if turns and self._no_heading(now):
            return "P7: no heading"
        return ""

    def _bypassed(self, now: int) -> bool:
        if now > self.bypass_until_us:
            return False
        return now - self.bypass_us <= 20_000_000

    def _watch_sensor(self, gap_us: int, moving: bool) -> None:
        """How long the chair has moved since its sensor tells nothing, and how it stood then."""
        if self._senses():
            self.unseen_us = 0
            self.steep = abs(self.chair.tilt_deg) * 2 > self.rules.tilt_limit_deg + 1
        elif moving:
            self.unseen_us += gap_us

    def _tilted(self, now: int) -> bool:
        chair = self.chair
        if not self._senses():
            return self.unseen_us > (150 * MS if self.steep else 5_000 * MS)
        if chair.tilted_us < 0:
            return False
        since_us = chair.tilted_us
        if chair.fit_us >= 0:
            since_us = max(since_us, chair.fit_us + _SENSOR_STARTS_US)
        return now - since_us > self.late(100, now) + 10 * MS

    def _senses(self) -> bool:
        chair = self.chair
        return chair.frozen_us < 0 and chair.unfit_us < 0 and self.world.imu.fault == 0

    def _no_heading(self, now: int) -> bool:
        chair = self.chair
        late = self.late(50, now)
        if self.world.imu_failed_us >= 0 and now - self.world.imu_failed_us > late:
            return True
        if chair.unfit_us >= 0 and now - chair.unfit_us > late:
            return True
        if chair.jumped_us >= 0 and late < now - chair.jumped_us < 500 * MS:
            return True
        frozen = chair.frozen_us >= 0 and now - chair.frozen_us > late + 10 * MS
        return frozen and 0 <= self.turning_us < now - late - 10 * MS

    def _judge_size(self, fields: dict[str, int], linear: int, turn: int, now: int) -> None:
        rules = self.rules
        verb, mode = fields["verb"], fields["mode"]
        stepping = mode != codes.CONTINUOUS and verb != codes.DRIVE
        cap = fields["cap_permille"]
        most_turn = rules.step_turn_permille if stepping else rules.turn_permille
        straight = verb == codes.DRIVE and fields["turn_permille"] == 0
        if verb == codes.FORWARD or (straight and fields["linear_permille"] > 0):
            most_turn = rules.hold_permille
        elif verb == codes.BACKWARD or straight:
            most_turn = 0
        if mode == codes.AUTO:
            caps = rules.auto_permille
            along = caps[_FORWARD if linear > 0 else _BACKWARD]
            aside = caps[_LEFT if turn > 0 else _RIGHT]
            if abs(linear) > _counts(along) or abs(turn) > _counts(aside):
                raise Violation("P19", f"auto moves {linear} {turn}, above its own speed")
        if abs(linear) > _counts(min(cap, rules.linear_permille)):
            raise Violation("P4", f"linear {linear} beyond what settings and command allow")
        if abs(turn) > _counts(min(cap, most_turn)):
            raise Violation("P4", f"turn {turn} beyond what settings and command allow")
        wrong = (
            (verb == codes.FORWARD and linear < 0)
            or (verb == codes.BACKWARD and linear > 0)
            or (verb in (codes.LEFT, codes.RIGHT) and linear != 0)
            or (verb == codes.DRIVE and linear * fields["linear_permille"] < 0)
            or (verb == codes.DRIVE and turn * fields["turn_permille"] < 0)
            or (mode == codes.CONTINUOUS and verb == codes.LEFT and turn < 0)
            or (mode == codes.CONTINUOUS and verb == codes.RIGHT and turn > 0)
        )
        if wrong:
            raise Violation("P13", f"{codes.VERBS[verb]} moves {linear} {turn}")


def _permille(counts: int) -> int:
    """Of full deflection, as told: the least that moves a wiper so far."""
    least = -(-abs(counts) * 1000 // _SPAN)
    return least if counts > 0 else -least


def _counts(permille: int) -> int:
    return permille * _SPAN // 1000 + 1
