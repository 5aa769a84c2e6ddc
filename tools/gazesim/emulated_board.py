"""The emulated Teensy as the simulator's board: QEMU on the same bank, joined to the same cable."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import socket
import subprocess
import time
from pathlib import Path

from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.cable import Cable

ELF = "firmware.elf"
_QEMU = "qemu-system-arm"
_ROOT = Path(__file__).resolve().parents[2]
# What only a PC needs: no use on a board, and half of its flash.
_PC_ONLY = ("virtual.py", "unix_cpython.py", "unix_micropython.py", "bank_devices.py")
_PR_SET_PDEATHSIG = 1
_CAUSE_RESET = 5
_MAKE_UP_TICKS = 1  # host flag: ticks lost to stalls of the PC are made up for
_SEND_BUFFER = 4608  # small, so that a board that does not read holds up the host soon
_ICOUNT_SHIFT = 2  # 4 ns an instruction: slow enough for QEMU, fast enough for the firmware
_libc = ctypes.CDLL(None, use_errno=True)


def _die_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class EmulatedBoard:
    """Runs the emulated Teensy of `folder_m7`; as BoardProcess, call for call.

    Its time is wall time; or, `counted`, a count of its instructions that waits when it idles:
    then a loaded PC makes the board slow, watchdog included, where it would else miss deadlines.
    Its flash is part of the bank and outlives it. A board that resets itself (watchdog, reset
    from the REPL) shows at the host as on USB: `poll` lets the port vanish and come back.
    """

    def __init__(
        self,
        folder_m7: Path,
        bank: Bank,
        bank_path: Path,
        folder: Path,
        cable: Cable,
        counted: bool = False,
    ) -> None:
        self._elf = folder_m7 / ELF
        self._clock = ("-icount", f"shift={_ICOUNT_SHIFT},sleep=on") if counted else ()
        self._bank = bank
        self._bank_path = bank_path.resolve()
        self._folder = folder.resolve()
        self._cable = cable
        self._cable_in = True
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._paused = False
        self._boots = 0
        self.resets = 0  # times it reset itself

    @property
    def running(self) -> bool:
        """Whether the emulation is there (paused or not)."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start it; OSError when QEMU or the emulated board's file is not there."""
        if not self._elf.is_file():
            raise FileNotFoundError(f"no emulated board: {self._elf} is not there")
        self._folder.mkdir(parents=True, exist_ok=True)
        self._bank.set_u32(layout.HOST_FLAGS_AT, _MAKE_UP_TICKS)
        self._bank.set_u32(layout.EPOCH_S_AT, int(time.time()))
        self._bank.set_u32(layout.TICK_MS_AT, 0)
        ours, boards = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        # Not the other way: QEMU sends byte by byte, and the kernel charges each with ~1 kB.
        path = str(self._bank_path).replace(",", ",,")  # QEMU's way to quote
        memory = f"memory-backend-file,id=bank,share=on,size={layout.SIZE},mem-path={path}"
        words = [
            *(_QEMU, "-machine", "mps2-an500,memory-backend=bank", "-kernel", str(self._elf)),
            *("-object", memory),
            *("-chardev", f"socket,id=line,fd={boards.fileno()}", "-serial", "chardev:line"),
            *("-display", "none", "-monitor", "none"),
            *self._clock,
        ]
        try:
            with boards, open(self._folder / "board.log", "ab") as log:
                self._process = subprocess.Popen(
                    words,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    pass_fds=(boards.fileno(),),
                    start_new_session=True,  # Ctrl-C at the terminal is for the simulator
                    preexec_fn=_die_with_parent,
                )
        except OSError:
            ours.close()
            raise
        self._boots = self._bank.boot_count + 1
        self._line = ours
        self._paused = False
        self._cable.connect_board(ours.fileno())
        if self._cable_in:
            self._cable.plug()

    def install(self, root: Path = _ROOT) -> None:
        """Let the next start write the firmware of checkout `root` to its flash, then reset.

        A short cut for simulations, without the cable; `gazechair flash` is the real way.
        Raises ValueError when the firmware does not fit the bank's place for scripts.
        """
        self.run_instead(_install_script(root))

    def run_instead(self, script: bytes) -> None:
        """Let the next boot, and only that one, run `script` in place of its main.py.

        Raises ValueError when the script is too long for its place in the bank.
        """
        if len(script) > layout.SCRIPT_SIZE:
            raise ValueError(f"a script of {len(script)} bytes: at most {layout.SCRIPT_SIZE} fit")
        self._bank.buffer[layout.SCRIPT_AT : layout.SCRIPT_AT + len(script)] = script
        self._bank.set_u32(layout.SCRIPT_DONE_AT, 0)
        self._bank.set_u32(layout.SCRIPT_LEN_AT, len(script))

    def kill(self) -> None:
        """End it at once, as pulling its power does: the port vanishes."""
        self._cable.pull()
        self._cable.connect_board(-1)
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            self._process.wait(timeout=10.0)
            self._process = None
        if self._line is not None:
            self._line.close()
            self._line = None

    stop = kill

    def restart(self) -> None:
        """Reset it: as the board's own reset, the cause is handed over."""
        self.kill()
        self._bank.set_u32(layout.NEXT_CAUSE_AT, _CAUSE_RESET)
        self.start()

    def power_cycle(self) -> None:
        """Take its power away and give it back."""
        self.kill()
        self._bank.power_on()
        self.start()

    def pause(self) -> None:
        """Stop it in the middle of whatever it does, as a hang with interrupts off."""
        if self._process is not None:
            self._process.send_signal(signal.SIGSTOP)
            self._paused = True

    def resume(self) -> None:
        """Let it go on after `pause`."""
        if self._process is not None and self._paused:
            self._process.send_signal(signal.SIGCONT)
            self._paused = False

    def pull_cable(self) -> None:
        """Pull the board's USB plug at the host; the board itself keeps its power."""
        self._cable_in = False
        self._cable.pull()

    def plug_cable(self) -> None:
        """Plug it in again; the port shows as soon as the board runs."""
        self._cable_in = True
        if self.running:
            self._cable.plug()

    def poll(self) -> None:
        """Let the port vanish and come back after a reset of its own; start it if QEMU ended."""
        if self._process is None:
            return
        if self._process.poll() is not None:
            self.resets += 1
            self.kill()
            self.start()
            return
        boots = self._bank.boot_count
        if boots > self._boots:
            self.resets += boots - self._boots
            self._boots = boots
            self._cable.pull()
            if self._cable_in:
                self._cable.plug()


def _install_script(root: Path) -> bytes:
    """A program for the board that writes the firmware to its flash and resets."""
    files = {}
    for part in ("protocol", "firmware"):
        for file in sorted((root / part).rglob("*.py")):
            if file.name not in _PC_ONLY:
                place = "" if file.name == "main.py" else "lib/"
                files[f"/flash/{place}{file.relative_to(root / part)}"] = file.read_text()
    folders = sorted({str(parent) for path in files for parent in Path(path).parents})
    lines = ["import os, machine", f"for folder in {folders[2:]!r}:"]
    lines += [" try: os.mkdir(folder)", " except OSError: pass"]
    lines += [f"with open({path!r}, 'w') as f: f.write({text!r})" for path, text in files.items()]
    return "\n".join([*lines, "machine.reset()", ""]).encode()
