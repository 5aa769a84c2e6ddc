"""The whole firmware on a simulated chair in virtual time, with a plain host: one ms a step."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from gazeboard.app import App
from gazeboard.boards.virtual import VirtualBoard
from gazechair.board.board_commands import STOP_COMMAND, Clearance, Command
from gazechair.board.protocol import LinkProtocol
from gazechair.board.state import BoardState
from gazelink import codes
from gazesim.bank import Bank
from gazesim.rooms import Room
from gazesim.world import World

_CLEARANCE_MS = 50
_SERVICES_PER_MS = 2
_TICKS_MASK = 0x3FFFFFFF
_HALF = 0x20000000


class _Memory:
    """The board's files, and its end of the line."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self.to_board: deque[int] = deque()
        self.to_host = bytearray()

    def load(self, name: str) -> str | None:
        return self.texts.get(name)

    def store(self, name: str, text: str) -> None:
        self.texts[name] = text

    def remove(self, name: str) -> None:
        self.texts.pop(name, None)

    def read_byte(self) -> int:
        return self.to_board.popleft() if self.to_board else -1

    def write_some(self, buf: bytearray, start: int, end: int) -> int:
        self.to_host += buf[start:end]
        return end


class WholeChair:
    """App, devices, chair and a host that keeps `verb` pressed in `mode`; faults are public."""

    def __init__(self, profile: str = "3.1", room: str | Room = "open") -> None:
        self.now_ms = 0
        self.bank = Bank.in_memory()
        self.world = World(self.bank, room, profile)
        self._memory = _Memory()
        self._board = VirtualBoard(
            self.bank.buffer, self._memory, self._memory, 0x0B07, self._ticks_us, _ticks_diff
        )
        self.app = App(self._board)
        self._protocol = LinkProtocol(iter(range(7, 9999)).__next__)
        self._protocol.opened(0.0)
        self.state: BoardState | None = None
        self.speaks = True  # False: the host has died
        self.holds = True  # False: no more proof that the press is active
        self.sees = True  # False: no more clearance, except from `tell`
        self.scanned = b""  # what the lidar sent in this ms
        self.serves = True  # False: the service loop hangs
        self.blocked = 0
        self.owner = codes.CARETAKER
        self._command = STOP_COMMAND

    def _ticks_us(self) -> int:
        return self.now_ms * 1000 & _TICKS_MASK

    def now_s(self) -> float:
        """Everybody's clock."""
        return self.now_ms / 1000

    def press(self, verb: int, mode: int, turn_permille: int = 0, pulse_ms: int = 0) -> None:
        """Begin a press and keep it active."""
        edge = self._command.edge % 255 + 1
        self.holds = True
        self._command = Command(
            verb, mode, edge, self.owner, 0.0, turn_permille=turn_permille, pulse_ms=pulse_ms
        )

    def release(self) -> None:
        """Stop."""
        self._command = STOP_COMMAND

    def order(self, action: int, owner: int) -> None:
        """Arm, disarm, emergency stop."""
        self._protocol.order(action, owner, self.now_s())

    def reconnect(self) -> None:
        """Another host takes over the line."""
        self._protocol.opened(self.now_s())

    def run(self, ms: int) -> None:
        """Let `ms` pass."""
        for _ in range(ms):
            self.one_ms()

    def one_ms(self) -> None:
        """Host, board, world."""
        self.now_ms += 1
        if self.speaks:
            self._host()
        self._board.tick(self.app)
        for _ in range(_SERVICES_PER_MS if self.serves else 0):
            self.app.service()
        self.scanned = self.world.step(0.001)

    def tell(self, clearance: Clearance) -> None:
        """What the host's lidars leave free."""
        self._protocol.clearance(clearance, self.now_s())

    def _host(self) -> None:
        now_s = self.now_s()
        data = bytes(self._memory.to_host)
        self._memory.to_host.clear()
        for event in [*self._protocol.feed(data, now_s), *self._protocol.check(now_s)]:
            if isinstance(event, BoardState):
                self.state = event
        if self.holds and self._command.verb != codes.STOP:
            command = self._command
            self._command = replace(command, ttl_deadline_s=now_s + 0.3)
        self._protocol.command(self._command, now_s)
        if self.sees and self.now_ms % _CLEARANCE_MS == 0:
            seen = Clearance(self.blocked, codes.SIMULATED, now_s - 0.02)
            self._protocol.clearance(seen, now_s)
        self._memory.to_board.extend(self._protocol.poll(now_s))

    @property
    def wipers(self) -> tuple[int, int]:
        """The pot's registers: (linear, turn)."""
        return self.world.pot.poll()

    def arm(self) -> None:
        """Armed by the owner. RuntimeError when that fails for 6 s."""
        for _ in range(6000):
            if self.app.safety.state == codes.ARMED:
                return
            if self.app.safety.arm_reason == codes.NO_REASON and self.now_ms % 100 == 0:
                self.order(codes.ARM, self.owner)
            self.one_ms()
        reason = codes.reason_name(self.app.safety.arm_reason)
        raise RuntimeError(f"the simulated board does not arm: {reason}")


def _ticks_diff(a: int, b: int) -> int:
    return ((a - b + _HALF) & _TICKS_MASK) - _HALF
