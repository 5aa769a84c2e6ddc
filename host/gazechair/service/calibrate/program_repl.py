"""A board's REPL that runs a program and forwards each line it prints."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Protocol

from gazechair.service.flash.board_files import BoardFiles
from gazechair.service.flash.repl import Repl

_END_S = 10.0


class ProgramBoard(BoardFiles, Protocol):
    """Files as in flashing, and programs."""

    def program(self, code: str, on_line: Callable[[str], None]) -> None:
        """Run `code`, which must print at least every 10 s and end when a byte arrives.

        `on_line` must not raise. Raises FlashError when the program fails or the board dies.
        """


class ProgramRepl(Repl):
    """Implements ProgramBoard through mpremote."""

    def program(self, code: str, on_line: Callable[[str], None]) -> None:
        """Run `code`; `on_line` gets each line. A KeyboardInterrupt here ends it there first."""
        line = bytearray()

        def take(data: bytes) -> None:
            for byte in data:
                if byte == ord("\n"):
                    text = line.decode("utf-8", "replace").strip()
                    line.clear()
                    on_line(text)
                elif byte != 4:  # the end of the output
                    line.append(byte)

        with self._answering("run the calibration on"):
            try:
                self._transport.exec(code, data_consumer=take)
            except KeyboardInterrupt:
                # No Ctrl-C to the board: inside an I2C transfer that can corrupt its memory.
                with contextlib.suppress(*self._errors):
                    self._transport.serial.write(b"q")
                    self._transport.follow(_END_S)
                raise
