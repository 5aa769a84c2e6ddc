"""One life of the whole firmware under the fuzzer: the loop of its milliseconds.

A life follows from its seed alone. What happens in it is a list of episodes (fuzz_episodes); each
draws from a generator of its own, so that one can be left out and the others stay what they are.
"""

from __future__ import annotations

import random
from collections.abc import Generator
from pathlib import Path
from typing import Any

from gazeboard.app import App
from gazeboard.io import bootlog
from gazelink import codes, messages
from gazeprove.fuzz_board import TICKS, Board, World
from gazeprove.fuzz_chair import PERIOD_US, Chair
from gazeprove.fuzz_facts import Violation
from gazeprove.fuzz_host import Host, Reader
from gazeprove.fuzz_oracle import Oracle

Script = Generator[int, None, None]  # yields milliseconds to let pass
_WATCHDOG_US = 500_000
_WATCHDOG, _POWER = 3, 1
_RELAY_CLOSES, _RELAY_OPENS = 4, 15
_KEPT = 400

FOLLOWS, STAYS_OPEN, STAYS_CLOSED = range(3)


class Life:
    """A board, a host, a chair and the oracle over all."""

    def __init__(self, seed: int, folder: str, log: bool = False) -> None:
        rng = random.Random(seed)
        self.seed = seed
        self.rng = rng
        self.folder = folder
        starts = (0, TICKS - rng.randrange(20_000_000), TICKS * 1000 - rng.randrange(20_000_000))
        self.world = World(folder, rng.random() < 0.3, rng.choice(starts))
        self.host = Host(self.world, rng)
        self.chair = Chair(self.world, rng)
        self.oracle = Oracle(self.world, self.chair)
        self._reader = Reader()
        self._log: list[str] | None = [] if log else None
        self.state: dict[str, Any] = {}
        self.replied = 0  # answers about settings
        self.period_us = 1000
        self.gap_us = 0  # once, before the next tick
        self.service_alive = True
        self.services = 1  # slices after each tick
        self.tick_alive = True
        self.relay = FOLLOWS
        self.watchdog = rng.random() < 0.5
        self.ticks = 0
        self._on_ticks = 0
        self._off_ticks = 1000
        self._sense_us = self.world.now_us
        self._fast_service = rng.random() < 0.3
        self._noted: tuple[object, ...] = ()
        self.off = False  # the board stays in its REPL
        self.boot(_POWER)

    # -- power ---------------------------------------------------------------------------------

    def boot(self, cause: int) -> None:
        """The board comes up."""
        self.note(f"boot, cause {cause}")
        world = self.world
        world.enable = 0
        world.fed_us = world.now_us
        boot_id = self.rng.randrange(1, 65536)
        world.serial.cut()
        self._reader.forget()
        self._board = Board(world, boot_id, cause)
        if world.pot.fault == 0 and world.pot.registers != [170, 170]:
            raise Violation("P1", "not neutral before the first tick")
        damaged = bootlog.damaged(self._board)
        self.off = bootlog.watchdog_boots(self._board) >= bootlog.LIMIT
        self.oracle.boot_id = boot_id
        self.oracle.boot()
        self.oracle.emergency_kept = True
        self.state = {}
        if not self.off:
            self._app = App(self._board, 1 << codes.STORAGE if damaged else 0)

    # -- time ----------------------------------------------------------------------------------

    def run(self, script: Script) -> None:
        """Let the script's milliseconds pass. Raises Violation."""
        for ms in script:
            for _ in range(ms):
                self._one_ms()

    def _one_ms(self) -> None:
        world = self.world
        world.now_us += self.period_us + self.gap_us
        self.gap_us = 0
        now = world.now_us
        self.host.step()
        if now >= self._sense_us:
            self._sense_us = now + PERIOD_US
            self.chair.step(world.relay_closed)
        if self._fast_service and self.service_alive and not self.off:
            self._serve()
        if self.tick_alive and not self.off:
            self._tick()
        if not self.off and self.service_alive:
            for _ in range(self.services):
                self._serve()
        if world.serial.sent:
            self._listen()
        if self.watchdog and now - world.fed_us > _WATCHDOG_US and not self.off:
            self.boot(_WATCHDOG)

    def _tick(self) -> None:
        world = self.world
        self.ticks += 1
        before = world.enable
        pot = world.pot
        pot.failed = False
        raises = world.raises is not None
        self._app.tick()
        toggled = world.enable != before
        self._move_relay(toggled)
        registers = pot.registers
        if self._log is not None:
            self._note_outputs(registers, toggled, pot.failed)
        self.oracle.ticked(registers[0], registers[1], toggled, pot.failed, raises)
        if pot.illegal:
            raise Violation("P8", f"the potentiometer was sent {pot.illegal[0]!r}")

    def _note_outputs(self, registers: list[int], toggled: bool, failed: bool) -> None:
        now = (*registers, toggled, failed)
        if now != self._noted:
            self._noted = now
            self.note(
                f"tick {self.oracle.tick_count + 1}: wipers {registers}"
                f"{' enable' if toggled else ''}{' failed' if failed else ''}"
            )

    def _move_relay(self, toggled: bool) -> None:
        if toggled:
            self._on_ticks += 1
            self._off_ticks = 0
        else:
            self._off_ticks += 1
            if self._off_ticks >= _RELAY_OPENS:
                self._on_ticks = 0
        if self.relay == FOLLOWS:
            self.world.relay_closed = self._on_ticks >= _RELAY_CLOSES
        else:
            self.world.relay_closed = self.relay == STAYS_CLOSED

    def _serve(self) -> None:
        before = self.world.enable
        self._app.service()
        taken = self.world.serial.taken()
        if self._log is not None:
            for sent in taken:
                old_ms = (self.world.now_us - sent.born_us) // 1000
                self.note(f"after tick {self.oracle.tick_count}, {old_ms} ms old: {sent}")
        self.oracle.served(taken)
        if self.world.enable != before and self.world.enable:
            raise Violation("P10", "the service loop raised the enable line")

    def _listen(self) -> None:
        sent = self.world.serial.sent
        frames = self._reader.take(sent, self.host.seed)
        sent.clear()
        for kind, stamp, fields in frames:
            self.host.received(kind, stamp, fields)
            if kind == messages.STATE.type_id:
                self.state = fields
                self.oracle.reported(stamp, fields)
            elif kind == messages.SETTING_REPLY.type_id:
                self.replied += 1
                wrong = self.oracle.rules.confirmed(fields)
                if wrong:
                    raise Violation("P1", wrong)

    # -- for episodes --------------------------------------------------------------------------

    @property
    def enabled(self) -> bool:
        """The enable line is changing: armed, or about to be."""
        return self.oracle.enabled_at >= 0

    @property
    def moving(self) -> bool:
        """The wipers are not neutral."""
        return tuple(self.world.pot.registers) != self.oracle.rules.neutral

    def note(self, text: str) -> None:
        """Kept for who looks at a broken life."""
        if self._log is not None:
            self._log.append(f"{self.world.now_us / 1000:.1f} ms: {text}")

    @property
    def story(self) -> list[str]:
        """The last of what was noted."""
        return (self._log or [])[-_KEPT:]

    def faults(self) -> int:
        """Fault bits as the board last reported them."""
        return int(self.state.get("faults", 0))

    def ready(self) -> Script:
        """Bring the chair to armed, as a patient caretaker would. It may not succeed."""
        host, world = self.host, self.world
        for _ in range(4):
            if self.enabled and self.state.get("status", 0) & 15 == codes.ARMED:
                return
            host.let_go()
            if self.faults() & ((1 << codes.EMERGENCY) | (1 << codes.WIPER)) or self.oracle.latched:
                host.order(codes.RESET_FAULTS, codes.CARETAKER)
                yield 210
            yield 650
            host.order(codes.ARM, self.rng.choice((codes.DRIVER, codes.CARETAKER)))
            yield 130
        assert world is self.world

    def setting(self, request: int, index: int = 0, value: int = 0) -> Script:
        """Ask about a setting and wait for the answer; without one the board is reset."""
        replied = self.replied
        self.host.send(messages.SETTING, request=request, index=index, value=value)
        for _ in range(40):
            yield 2
            if self.replied != replied:
                return
        self.boot(_POWER)

    def spoil_file(self, name: str, data: bytes | None) -> None:
        """A stored file holds something else, or is gone."""
        self.note(f"{name} holds {data!r:.40}")
        path = Path(self.folder) / name
        if data is None:
            path.unlink(missing_ok=True)
        else:
            path.write_bytes(data)
        if name == "settings.json":
            self.oracle.rules.spoil(data is not None)
        elif name == "emergency":
            self.oracle.emergency_kept = False

    def drive(self, **how: int) -> Script:
        """A press by the owner, and some time in which it moves the chair."""
        rng = self.rng
        owner = self.oracle.owner or codes.DRIVER
        verb = how.pop("verb", 0) or rng.choice(
            (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE)
        )
        mode = how.pop("mode", -1)
        if mode < 0:
            mode = rng.choice((codes.STEP, codes.CONTINUOUS, codes.CONTINUOUS, codes.CONTINUOUS))
        if verb == codes.DRIVE:
            how.setdefault("linear", rng.choice((0, 400, -400, 1000, -700)))
            how.setdefault("turn", rng.choice((0, 0, 500, -500, 900)))
        if rng.random() < 0.2:
            how.setdefault("cap", rng.randrange(100, 1000))
        self.host.press(verb, mode, owner, **how)
        self.note(f"press {self.host.held}")
        yield rng.randrange(20, 120)
