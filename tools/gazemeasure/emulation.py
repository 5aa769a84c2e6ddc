"""Runs a program and its files on the emulated Teensy, where time is a count of instructions."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

import gazesetup
from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.board_files import LIB, install_script
from gazesim.emulated_board import ELF, machine_words

_CLOCK = "shift=1,sleep=off"  # 2 ns an instruction; idle time is skipped
INSTRUCTIONS_PER_US = 500
_PROGRAM = f"{LIB}/measured.py"
_POLL_S = 0.05
_LINGER_S = 0.2


class EmulationError(Exception):
    """The program failed; the text has the end of its output."""


def run(program: str, files: Mapping[str, str], limit_s: float) -> bytes:
    """Output of `program` (MicroPython text), run from reset with `files` on the board's flash:
    {path on the board: text}.

    Its times are reproducible to the instruction. Raises gazesetup.NotAvailable without the
    emulated board, EmulationError when the program fails or takes longer than `limit_s` real time.
    """
    elf = gazesetup.find_m7() / ELF
    qemu = gazesetup.ensure_qemu()
    script = install_script({**files, _PROGRAM: program}, then="import measured")
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        folder = Path(name)
        bank = Bank(folder / "bank")
        try:
            bank.set_script(script)
        except ValueError as error:
            bank.close()
            raise EmulationError(str(error)) from error
        words = machine_words(elf, folder / "bank", f"file,path={folder / 'line'}")
        process = subprocess.Popen([str(qemu), *words, "-icount", _CLOCK], stdin=subprocess.DEVNULL)
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
