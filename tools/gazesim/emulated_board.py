"""The emulated Teensy as the simulator's board: QEMU on the same bank, joined to the same cable."""

from __future__ import annotations

import signal
import socket
import subprocess
import time
from pathlib import Path
from typing import BinaryIO

from gazeboard.boards import bank_layout as layout
from gazesetup.family import dies_with_me
from gazesim.bank import Bank
from gazesim.board_files import firmware_files, install_script
from gazesim.cable import Cable
from gazesim.cabled_board import CabledBoard

ELF = "firmware.elf"
_QEMU = "qemu-system-arm"
_PORT_MS = 50  # of the board's own time, from reset to its port
_PORT_LIMIT_S = 30.0  # of the PC's; a board that keeps its interrupts off would never get there
_PORT_POLL_S = 0.005
_MAKE_UP_TICKS = 1  # host flag: ticks lost to stalls of the PC are made up for
_ICOUNT_SHIFT = 2  # 4 ns an instruction: slow enough for QEMU, fast enough for the firmware


def machine_words(elf: Path, bank_path: Path, line: str) -> list[str]:
    """QEMU's arguments for the emulated Teensy, its serial line being the chardev `line`."""
    path = str(bank_path).replace(",", ",,")  # QEMU's quoting
    memory = f"memory-backend-file,id=bank,share=on,size={layout.SIZE},mem-path={path}"
    return [
        *("-machine", "mps2-an500,memory-backend=bank", "-kernel", str(elf)),
        *("-object", memory),
        *("-chardev", f"{line},id=line", "-serial", "chardev:line"),
        *("-display", "none", "-monitor", "none"),
    ]


class EmulatedBoard(CabledBoard):
    """Runs the emulated Teensy of `folder_m7`.

    Its time is wall time; or, `counted`, a count of its instructions that waits when it idles:
    then a loaded PC makes the board slow, watchdog included, where it would else miss deadlines.
    Its flash is part of the bank and outlives it. A board that resets itself (watchdog, reset
    from the REPL) appears to the host as on USB: `poll` lets the port vanish and reappear.
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
        super().__init__(bank, bank_path, folder, cable)
        self._elf = folder_m7 / ELF
        self._clock = ("-icount", f"shift={_ICOUNT_SHIFT},sleep=on") if counted else ()
        self._boots = 0
        self._installing = False

    def _launch(self, line: socket.socket, log: BinaryIO) -> subprocess.Popen[bytes]:
        if not self._elf.is_file():
            raise FileNotFoundError(f"no emulated board: {self._elf} is not there")
        self._bank.set_u32(layout.HOST_FLAGS_AT, _MAKE_UP_TICKS)
        self._bank.set_u32(layout.EPOCH_S_AT, int(time.time()))
        self._bank.set_u32(layout.TICK_MS_AT, 0)
        self._boots = self._bank.boot_count + 1
        chardev = f"socket,fd={line.fileno()}"
        return subprocess.Popen(
            [_QEMU, *machine_words(self._elf, self._bank_path, chardev), *self._clock],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            pass_fds=(line.fileno(),),
            start_new_session=True,  # Ctrl-C at the terminal is for the simulator
            preexec_fn=dies_with_me(signal.SIGKILL),
        )

    def install(self) -> None:
        """Let the next start write this checkout's firmware to its flash, then reset.

        A short cut for simulations, without the cable; `gazechair flash` is the real procedure.
        Its port appears when it has restarted: bytes sent earlier could interrupt the work.
        Raises ValueError when the firmware does not fit the bank's place for scripts.
        """
        self._installing = True
        self.run_instead(install_script(firmware_files(), "import machine\nmachine.reset()"))

    def run_instead(self, script: bytes) -> None:
        """Let the next boot, and only that one, run `script` in place of its main.py.

        Raises ValueError when the script is too long for its place in the bank.
        """
        self._bank.set_script(script)

    def poll(self) -> None:
        """Let the port vanish and reappear after its own reset; start it if QEMU ended."""
        super().poll()
        if self._process is None:
            return
        boots = self._bank.boot_count
        if boots > self._boots:
            self.resets += boots - self._boots
            self._boots = boots
            self._installing = False
            self._cable.pull()
            # Or the time of the boot before would be taken for this one's.
            self._bank.set_u32(layout.TICK_MS_AT, 0)
            self._show_port()

    def _show_port(self) -> None:
        if self._installing:
            self._cable.pull()
            return
        # No USB host gives a device its port in its first milliseconds, and bytes sent to the
        # board then would interrupt it before it can prevent that (byte 3 is Ctrl-C).
        end_s = time.monotonic() + _PORT_LIMIT_S
        while self._bank.tick_ms < _PORT_MS and self.running and time.monotonic() < end_s:
            time.sleep(_PORT_POLL_S)
        super()._show_port()
