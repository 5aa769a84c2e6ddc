"""Runs a program with the firmware on the emulated Teensy, time being a count of instructions."""

from __future__ import annotations

import subprocess
import tempfile
import time
from pathlib import Path

import gazesetup
from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.board_files import firmware_files, install_script, m7_folder

_CLOCK = "shift=1,sleep=off"  # 2 ns an instruction; idle time is skipped
INSTRUCTIONS_PER_US = 500
_POLL_S = 0.05
_LINGER_S = 0.2


class EmulationError(Exception):
    """The program did not end well; the text holds the end of what it printed."""


def run(program: str, limit_s: float) -> bytes:
    """Output of `program` (MicroPython text), run from reset with the firmware importable.

    Its times repeat to the instruction. Raises gazesetup.NotAvailable without the emulated board,
    EmulationError when the program fails or takes longer than `limit_s` of the PC's time.
    """
    elf = m7_folder() / "firmware.elf"
    if not elf.is_file():
        raise gazesetup.NotAvailable(
            f"no emulated board at {elf.parent}: set GAZECHAIR_M7 to its folder"
        )
    qemu = gazesetup.ensure_qemu()
    files = firmware_files()
    del files["/flash/main.py"]
    files["/flash/lib/measured.py"] = program
    script = install_script(files, then="import measured")
    if len(script) > layout.SCRIPT_SIZE:
        raise EmulationError(f"the program is {len(script)} bytes long; {layout.SCRIPT_SIZE} fit")
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        folder = Path(name)
        bank = Bank(folder / "bank")
        bank.buffer[layout.SCRIPT_AT : layout.SCRIPT_AT + len(script)] = script
        bank.set_u32(layout.SCRIPT_DONE_AT, 0)
        bank.set_u32(layout.SCRIPT_LEN_AT, len(script))
        words = [str(qemu), "-machine", "mps2-an500,memory-backend=bank", "-kernel", str(elf)]
        words += ["-object", _memory(folder / "bank"), "-icount", _CLOCK]
        words += ["-chardev", f"file,id=line,path={folder / 'line'}", "-serial", "chardev:line"]
        words += ["-display", "none", "-monitor", "none"]
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL)
        try:
            end_s = time.monotonic() + limit_s
            while not bank.u32(layout.SCRIPT_DONE_AT) and process.poll() is None:
                if time.monotonic() > end_s:
                    raise EmulationError(f"not finished after {limit_s:g} s")
                time.sleep(_POLL_S)
            time.sleep(_LINGER_S)
            done = bank.u32(layout.SCRIPT_DONE_AT)
        finally:
            process.kill()
            process.wait()
            bank.close()
        output = (folder / "line").read_bytes()
    if done != 1:
        raise EmulationError(output[-600:].decode(errors="replace"))
    return output


def _memory(path: Path) -> str:
    quoted = str(path).replace(",", ",,")  # QEMU's way to quote
    return f"memory-backend-file,id=bank,share=on,size={layout.SIZE},mem-path={quoted}"
