"""A live board under test: the emulated Teensy in its simulated chair, or a real one on a port."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from gazeboard.boards import bank_layout as layout
from gazeboard.boards import pins
from gazelink import codes
from gazesim.bank import Bank
from gazesim.cable import Cable
from gazesim.emulated_board import EmulatedBoard
from gazesim.world import World
from livehost import NEUTRAL_OUTPUT, STOP, LiveHost

# Wall time a condition may take: the emulation keeps up with real time, but machines stall.
LIMIT_S = 120.0
NOBODY_S = 1.0  # the same where there is nobody to answer
PRINTED = 300  # characters of what an emulation said before it ended; its registers follow
STEP_S = 0.001
NEUTRAL = (170, 170)
# The flashed main.py with something in between; a script runs in place of it at one boot only.
_PATCHED = """
text = open('/flash/main.py').read()
at = text.index('from gazeboard')
exec(text[:at])
{}
exec(text[at:])
"""


class EmulationEnded(Exception):
    """QEMU is gone, which no test asked for; the text has what it said."""


class Emulation(EmulatedBoard):
    """One that never ends by itself: an emulated Teensy that resets itself stays the same QEMU."""

    def poll(self) -> None:
        """Raises EmulationEnded where a simulation would take that for a reset."""
        if self._process is not None and (code := self._process.poll()) is not None:
            printed = (self._folder / "board.log").read_text(errors="replace")[:PRINTED].strip()
            raise EmulationEnded(f"QEMU ended with {code}: {printed or 'it printed nothing'}")
        super().poll()


class LiveBoard:
    """What every live board can be asked; `host` is on its port. Times are the board's ticks."""

    def __init__(self, path: Path, simulated: bool) -> None:
        """`simulated`: what is behind the port at `path` is no real board."""
        self.simulated = simulated
        self.host = LiveHost(path, codes.SIMULATED if simulated else codes.REAL)
        self._edge = 0

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Let time pass until `condition` holds; fails, saying `what`, when it never does."""
        end = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < end, f"never: {what}; {self.situation()}"
            self.pass_time()
            time.sleep(0.001)

    def run_ms(self, duration_ms: int) -> None:
        """Let that much of the board's time pass; it must be telling the time (in a session)."""
        end = self.host.ticks + duration_ms
        self.until(lambda: self.host.ticks >= end, f"{duration_ms} ms of the board's time")

    def pass_time(self) -> None:
        """One pass of everything that moves."""
        self.host.poll()

    def situation(self) -> str:
        """For a failed test's message."""
        host = self.host
        return (
            f"hellos {host.hellos[-1:]}, state {host.state}, stats {host.stats},"
            f" heard {bytes(host.recent_bytes[-300:])!r}"
        )

    def connect(self) -> None:
        """A session, and a first state."""
        self.until(lambda: self.host.in_session and self.host.state, "a session with state frames")

    def ask_to_arm(self, condition: Callable[[], bool], what: str) -> None:
        """Until `condition` holds; asked again when a stall of the PC came between."""

        def so() -> bool:
            host = self.host
            host.command = STOP
            if host.safety == codes.DISARMED and host.state["arm_reason"] == codes.NO_REASON:
                host.order(codes.ARM)
                self.run_ms(300)
            return condition()

        self.until(so, what)

    def new_edge(self) -> int:
        """The next press of the driver."""
        self._edge = self._edge % 255 + 1
        return self._edge

    def stop(self) -> None:
        """Leave the board alone."""
        self.host.close()


class EmulatedLiveBoard(LiveBoard):
    """The emulated Teensy; its world follows the board's own clock, so a stalled PC stalls both."""

    def __init__(self, m7: Path, folder: Path, flash: bytes | None) -> None:
        """`flash`: content of its flash memory, None for a factory-new one."""
        self.bank = Bank(folder / "bank")
        if flash is not None:
            end = layout.FLASH_AT + layout.FLASH_SIZE
            self.bank.buffer[layout.FLASH_AT : end] = flash
        self.world = World(self.bank, "living", tick_stall_s=0.1)
        self.cable = Cable(folder / "port")
        self.board = Emulation(
            m7, self.bank, folder / "bank", folder / "files", self.cable, counted=True
        )
        super().__init__(folder / "port", simulated=True)
        self._tick = 0
        self._ending = threading.Event()
        self._ended: EmulationEnded | None = None  # in the background

    def start(self, patch: str = "") -> None:
        """Switch it on; `patch` is run in the firmware, once, before its App is imported."""
        if patch:
            self.board.run_instead(_PATCHED.format(patch).encode())
        self.cable.start()
        self.board.start()

    def stop(self) -> None:
        """End everything that was started."""
        super().stop()
        self.board.stop()
        self.cable.stop()
        self.bank.close()

    @property
    def flash(self) -> bytes:
        """What is in its flash memory now."""
        return bytes(self.bank.buffer[layout.FLASH_AT : layout.FLASH_AT + layout.FLASH_SIZE])

    @property
    def real_wipers(self) -> tuple[int, int]:
        """Linear and turn counts as the potentiometer holds them."""
        return self.world.pot.poll()

    @property
    def enable_toggles(self) -> int:
        """Writes to the enable line so far."""
        return self.bank.pin(pins.ENABLE).out_count

    def run_ms(self, duration_ms: int) -> None:
        """Let that much of the board's time pass, whether it talks or not."""
        end = self._tick + duration_ms
        self.until(lambda: self._tick >= end, f"{duration_ms} ms of the board's time")

    def pass_time(self) -> None:
        """The world up to the board's clock, then the host."""
        self.board.poll()
        now = self.bank.tick_ms
        if now < self._tick:  # a reset
            self._tick = 0
        while self._tick < now:
            self._tick += 1
            self.world.step(STEP_S)
        super().pass_time()

    def start_background(self) -> None:
        """Let time pass in a thread of its own, the port being free for somebody else."""
        self.host.connected = False
        self.host.poll()
        self._ending.clear()
        self._thread = threading.Thread(target=self._pump, name="board's time")
        self._thread.start()

    def stop_background(self) -> None:
        """The test lets time pass again, and has the port back. Raises EmulationEnded."""
        self._ending.set()
        self._thread.join(LIMIT_S)
        self.host.connected = True
        if self._ended is not None:
            raise self._ended

    def _pump(self) -> None:
        try:
            while not self._ending.wait(0.002):
                self.pass_time()
        except EmulationEnded as ended:
            self._ended = ended
            self.cable.pull()  # whoever waits for an answer need not

    def cut_power(self) -> None:
        """In the background's time: the board loses its power now."""
        self._ending.set()
        self._thread.join(LIMIT_S)
        self.board.kill()

    def situation(self) -> str:
        """For a failed test's message."""
        return (
            f"{super().situation()}, wipers {self.real_wipers}, relay"
            f" {'closed' if self.world.relay.closed else 'open'}, boots {self.bank.boot_count},"
            f" tick {self.bank.tick_ms}"
        )

    def arm(self) -> None:
        """Ready, asked for, armed."""
        self.ask_to_arm(lambda: self.host.safety == codes.ARMED, "armed")

    def drive(self, verb: int = codes.FORWARD) -> None:
        """Armed and moving; pressed anew when a stall of the PC came between."""

        def moving() -> bool:
            if self.host.safety != codes.ARMED:
                self.arm()
            if self.host.output == NEUTRAL_OUTPUT:
                self.host.hold(verb, self.new_edge())
                self.run_ms(60)
            return self.host.output != NEUTRAL_OUTPUT

        self.arm()
        self.host.hold(verb, self.new_edge())
        self.run_ms(60)
        self.until(moving, "moving")


class Flashed(NamedTuple):
    """A factory-new emulated Teensy after `gazechair flash`: what that said, and its memory."""

    printed: str
    flash: bytes
