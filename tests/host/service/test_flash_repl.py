"""The board's REPL is entered, however late it answers."""

import os
import threading
import tty

import pytest

from gazechair.service.flash import repl
from patience import PATIENCE_S

BANNER = b"raw REPL; CTRL-B to exit\r\n>"


class LateBoard:
    """A raw REPL without raw paste, which answers its first two requests only after the second."""

    def __init__(self) -> None:
        self._fd, self._port = os.openpty()
        tty.setraw(self._port)
        self.path = os.ttyname(self._port)
        self._banners = 0
        self._thread = threading.Thread(target=self._run, name="late board")
        self._thread.start()

    def _run(self) -> None:
        received = b""
        while b"\x18" not in received:
            received += os.read(self._fd, 1024)
            if received.endswith(b"\x05A\x01"):
                os.write(self._fd, BANNER)
            elif received.endswith(b"\x01"):
                self._banners += 1
                if self._banners > 1:
                    os.write(self._fd, BANNER * (2 if self._banners == 2 else 1))
            elif received.endswith(b"\x04"):
                os.write(self._fd, b"OK\x04\x04>")
            else:
                continue
            received = b""

    def stop(self) -> None:
        os.write(self._port, b"\x18")
        self._thread.join(PATIENCE_S)
        os.close(self._fd)
        os.close(self._port)


def test_a_slow_board_that_answers_each_request_late_is_entered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(repl, "_TRY_S", 0.3)
    monkeypatch.setattr(repl, "_TIMEOUT_S", 0.5)
    board = LateBoard()
    try:
        repl.Repl(board.path).close()
    finally:
        board.stop()
