"""Puts files on the emulated board's flash and runs them there; a small host to talk with it."""

import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gazesetup
from gazeboard import joystick
from gazeboard.boards import pins
from gazelink import codes, frame, messages
from gazesim.bank import Bank
from gazesim.world import World

BOARD_ROOTS = ("protocol", "firmware")
PC_ONLY = ("virtual.py", "unix_cpython.py", "unix_micropython.py", "bank_devices.py")
START_S = 60.0
# Wall time a condition may take: the emulation keeps up with real time, but machines stall.
LIMIT_S = 120.0
STEP_S = 0.001
NEUTRAL = (170, 170)
# Both processes stall with the machine, and the board then does what it promises: ask it again.
INSIST_MS = 1000


def board_files() -> dict[str, str]:
    """What is flashed: path on the board -> text, main.py included."""
    files = {}
    for name in BOARD_ROOTS:
        root = gazesetup.ROOT / name
        for file in sorted(root.rglob("*.py")):
            if file.name not in PC_ONLY:
                files[str(file.relative_to(root))] = file.read_text()
    return files


def script(files: dict[str, str], then: str) -> str:
    """A script for the board that writes `files` to its flash and goes on with `then`."""
    folders = sorted({str(p) for path in files for p in Path(path).parents if str(p) != "."})
    lines = ["import os, sys", f"for folder in {folders!r}:"]
    lines += [" try: os.mkdir('/flash/' + folder)", " except OSError: pass"]
    lines += [
        f"with open('/flash/{path}', 'w') as f: f.write({text!r})" for path, text in files.items()
    ]
    return "\n".join([*lines, then, ""])


def execute(m7: Path, text: str, folder: Path) -> str:
    """Run a script from reset, time being a count of instructions; return what it printed."""
    file = folder / "script.py"
    file.write_text(text)
    words = [sys.executable, str(m7 / "m7"), "exec", str(file), "--timeout", str(LIMIT_S)]
    result = subprocess.run(
        words,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LIMIT_S + START_S,
    )
    assert result.returncode == 0, f"on the emulated board:\n{result.stdout}{result.stderr}"
    return result.stdout


class EmulatedChair:
    """The real firmware on the emulated Teensy, in a simulated room, and a host on its cable.

    The world follows the board's own tick clock, so a stalled PC stalls both alike.
    """

    def __init__(self, m7: Path, folder: Path) -> None:
        self._command = [sys.executable, str(m7 / "m7")]
        self._folder = folder
        self.bank = Bank(folder / "bank.bin")
        self.world = World(self.bank, "living")
        self.encoder = frame.Encoder()
        self.decoder = frame.Decoder()
        self.hello: dict[str, Any] = {}
        self.state: dict[str, Any] = {}
        self.states_heard = 0
        self.talking = False
        self.speak_ms = 20
        self.command = (codes.STOP, codes.CONTINUOUS, 0, codes.DRIVER, 0, 0, 0)
        self.order: tuple[int, int, int] | None = None
        self.session = 0x1234
        self._stamp = 0
        self._tick = 0
        self._spoke_at = 0
        self._number = 0
        self._edge = 0

    def start(self) -> None:
        """Flash the firmware, start the board, connect; it boots while `until` runs."""
        install = self._folder / "install.py"
        install.write_text(script(board_files(), "import machine\nmachine.reset()"))
        uart = self._folder / "uart"
        self._m7(
            "start",
            # Ticks go on in step with instructions when the PC stalls.
            "--icount-rt",
            "--bank",
            self._folder / "bank.bin",
            "--script",
            install,
            "--socket",
            uart,
        )
        self._line = socket.socket(socket.AF_UNIX)
        self._line.settimeout(START_S)
        self._line.connect(str(uart))
        self._line.setblocking(False)

    def stop(self) -> None:
        """End the emulation."""
        self._m7("stop")
        self._line.close()

    def _m7(self, action: str, *more: str | Path) -> None:
        words = [*self._command, action, "--dir", str(self._folder), *map(str, more)]
        subprocess.run(
            words,
            check=True,
            timeout=START_S,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
        )

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Let time pass until `condition` holds; fails, saying `what`, when it never does."""
        end = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < end, f"never: {what}; hello {self.hello}, state {self.state}"
            self._pass()
            time.sleep(0.001)

    def arm(self) -> None:
        """Order arming until it is armed."""
        self._insist(lambda: self.safety_state == codes.ARMED, "armed", self._order_arming)

    def drive(self, verb: int, condition: Callable[[], bool], what: str) -> None:
        """Hold `verb` until `condition`: arming and pressing anew after stalls."""

        def again() -> None:
            if self.safety_state == codes.DISARMED:
                self.command = (codes.STOP, codes.CONTINUOUS, self._edge, codes.DRIVER, 0, 0, 0)
                self._order_arming()
            elif self.wipers == NEUTRAL:
                self._edge = self._edge % 255 + 1
                self.command = (verb, codes.CONTINUOUS, self._edge, codes.DRIVER, 300, 0, 0)

        self._insist(condition, what, again)

    def _insist(self, condition: Callable[[], bool], what: str, act: Callable[[], None]) -> None:
        """Let time pass until `condition`, acting now and every INSIST_MS of the board's time."""
        due = self._tick

        def acted() -> bool:
            nonlocal due
            if abs(self._tick - due) >= INSIST_MS:
                due = self._tick
                act()
            return condition()

        act()
        self.until(acted, what)

    def _order_arming(self) -> None:
        self._number += 1
        self.order = (codes.ARM, self._number, codes.DRIVER)

    @property
    def wipers(self) -> tuple[int, int]:
        """Linear and turn counts, as the potentiometer holds them."""
        linear, turn = self.bank.slot(pins.JOYSTICK_BUS, joystick.ADDRESS).read(0, 2)
        return linear, turn

    @property
    def safety_state(self) -> int:
        """The board's state, codes.DISARMED until it says otherwise."""
        return int(self.state.get("status", 0)) & 0x0F

    def _pass(self) -> None:
        now = self.bank.tick_ms
        if now < self._tick:  # a reset
            self._tick = self._spoke_at = 0
        while self._tick < now:
            self._tick += 1
            self.world.step(STEP_S)
        self._listen()
        # The first boot is the installation's.
        flashed = self.bank.boot_count > 1
        if self.talking and flashed and now - self._spoke_at >= self.speak_ms:
            self._spoke_at = now
            self._speak()

    def _listen(self) -> None:
        try:
            data = self._line.recv(65536)
        except BlockingIOError:
            return
        for byte in data:
            if self.decoder.feed(byte):
                self._heard(self.decoder.buf)

    def _heard(self, buf: bytearray) -> None:
        self._stamp = frame.u16(buf, messages.STAMP_AT)
        if buf[messages.TYPE_AT] == messages.HELLO.type_id:
            self.hello = messages.HELLO.unpack(buf)
            self.encoder.seed = self.decoder.seed = None
            if self.hello["session"] == self.session:
                seed = frame.session_seed(self.session, self.hello["boot"])
                self.encoder.seed = self.decoder.seed = seed
        elif buf[messages.TYPE_AT] == messages.STATE.type_id:
            self.state = messages.STATE.unpack(buf)
            self.states_heard += 1

    def _speak(self) -> None:
        if self.encoder.seed is None:
            hello = (0, 0, frame.schema_hash(), self.session, 0, 0, 1, 0, b"tests")
            self._send(messages.HELLO, hello)
            return
        self._send(messages.COMMAND, self.command)
        self._send(messages.CLEARANCE, (0, codes.SIMULATED, 5))
        if self.order:
            self._send(messages.ORDER, self.order)

    def _send(self, message: messages.Message, values: tuple[int | bytes, ...]) -> None:
        message.pack(self.encoder.body, values)
        n = self.encoder.finish(message, self._stamp)
        self._line.send(bytes(self.encoder.wire[:n]))
