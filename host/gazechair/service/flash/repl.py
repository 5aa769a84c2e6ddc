"""A board in MicroPython's REPL, through the mpremote library."""

from __future__ import annotations

import ast
import contextlib
import importlib
import io
import struct
import termios
from collections.abc import Iterator
from typing import Any

from serial import SerialException

from gazechair.service.flash.board_files import Facts
from gazechair.service.flash.errors import FlashError

_TIMEOUT_S = 10.0  # a flash erase takes up to 0.4 s, and a write may need several
_TRIES = 4  # to enter the REPL
_TRY_S = 3
_CHUNK = 1024
_WATCHDOG_MS = 128_000

_FACTS = """
import machine, os, sys
try:
    machine.Timer(-1, period=1000, callback=print, hard=True).deinit()
    hard = True
except (TypeError, ValueError):
    hard = False
print((sys.platform, os.uname().machine, tuple(sys.implementation.version)[:3],
    getattr(sys.implementation, '_mpy', 0), hard))
"""
_HELPERS = """
import hashlib, os
def _is_folder(p):
    try:
        return os.stat(p)[0] & 0x4000 != 0
    except OSError:
        return None
def _hashes(p):
    for e in os.ilistdir(p):
        q = p + '/' + e[0]
        if e[1] & 0x4000:
            _hashes(q)
        else:
            h = hashlib.sha256()
            b = bytearray(512)
            with open(q, 'rb') as f:
                while True:
                    n = f.readinto(b)
                    if not n:
                        break
                    h.update(memoryview(b)[:n])
            print((q, h.digest()), end=',')
def _remove(p):
    d = _is_folder(p)
    if d:
        for e in os.ilistdir(p):
            _remove(p + '/' + e[0])
        os.rmdir(p)
    elif d is not None:
        os.remove(p)
"""


class Repl:
    """Implements BoardFiles. Owns the port until `close` or `reset`."""

    def __init__(self, path: str) -> None:
        """Enter the raw REPL of the board at `path`, interrupting what it runs.

        Raises FlashError when mpremote is missing or no REPL answers.
        """
        try:
            module: Any = importlib.import_module("mpremote.transport_serial")
            errors: Any = importlib.import_module("mpremote.transport")
        except ImportError:
            raise FlashError(
                "mpremote is not installed; run `pip install 'gazechair[flash]'`"
            ) from None
        self._path = path
        self._errors: tuple[type[Exception], ...] = (
            errors.TransportError,
            OSError,
            SerialException,
            struct.error,  # mpremote, when an answer is cut off
            termios.error,
        )
        with self._answering("open"):
            self._transport = module.SerialTransport(path, timeout=_TIMEOUT_S)
            self._transport.serial.write_timeout = _TIMEOUT_S
        try:
            # mpremote prints what it received when this fails
            with self._answering("enter the REPL of"), contextlib.redirect_stdout(io.StringIO()):
                self._enter(errors.TransportError)
        except FlashError:
            self.close()
            raise

    # A firmware that is exiting may still swallow the first request; a slow board answers it late,
    # in place of the next answer.
    def _enter(self, refused: type[Exception]) -> None:
        for left in reversed(range(_TRIES)):
            try:
                self._transport.enter_raw_repl(soft_reset=False, timeout_overall=_TRY_S)
                self._transport.use_raw_paste = True  # a late answer seems to refuse it
                self._transport.exec(_HELPERS)
                return
            except refused:
                if not left:
                    raise

    @contextlib.contextmanager
    def _answering(self, doing: str) -> Iterator[None]:
        try:
            yield
        except self._errors as error:
            lines = str(error).strip().splitlines()
            why = f" ({lines[-1]})" if lines else ""
            raise FlashError(
                f"could not {doing} the board at {self._path}{why}; check its cable and repeat"
            ) from None

    def _run(self, code: str, doing: str) -> str:
        with self._answering(doing):
            output: bytes = self._transport.exec(code)
        return output.decode()

    def facts(self) -> Facts:
        """What it is."""
        platform, machine, version, mpy, hard = ast.literal_eval(self._run(_FACTS, "question"))
        return Facts(platform, machine, tuple(version), mpy, hard)

    def hashes(self, folder: str) -> dict[str, str]:
        """Every file below `folder` by its full path -> SHA-256 in hex; {} without a folder."""
        code = f"if _is_folder({folder!r}): _hashes({folder!r})"
        listed = ast.literal_eval(f"[{self._run(code, f'check {folder} on')}]")
        return {path: digest.hex() for path, digest in listed}

    def folders(self, folder: str) -> list[str]:
        """Names of the folders in `folder`."""
        code = f"print([e[0] for e in os.ilistdir({folder!r}) if e[1] & 0x4000])"
        names: list[str] = ast.literal_eval(self._run(code, f"list {folder} on"))
        return names

    def read(self, path: str) -> bytes | None:
        """A whole file, None when there is none."""
        if self._run(f"print(_is_folder({path!r}))", f"look for {path} on").strip() != "False":
            return None
        with self._answering(f"read {path} from"):
            return bytes(self._transport.fs_readfile(path, chunk_size=_CHUNK))

    def make_folder(self, path: str) -> None:
        """Make a folder, and those above it, unless it is there."""
        parts = path.strip("/").split("/")
        above = ["/" + "/".join(parts[: n + 1]) for n in range(1, len(parts))]
        code = f"for p in {above!r}:\n if not _is_folder(p): os.mkdir(p)"
        self._run(code, f"make {path} on")

    def write(self, path: str, content: bytes) -> None:
        """Write a file; half of it is there when the board dies meanwhile."""
        with self._answering(f"write {path} to"):
            self._transport.fs_writefile(path, content, chunk_size=_CHUNK)

    def rename(self, path: str, new_path: str) -> None:
        """Rename a file, in one step, over an older one if there is one."""
        self._run(f"os.rename({path!r}, {new_path!r})", f"rename {path} on")

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with all in it; nothing happens when it is not there."""
        self._run(f"_remove({path!r})", f"remove {path} from")

    def free_bytes(self) -> int:
        """Free room of its flash."""
        code = "s = os.statvfs('/flash'); print(s[0] * s[3])"
        return int(self._run(code, "ask for free room on"))

    def feed_watchdog(self) -> None:
        """Give it another 128 s; only for a board whose watchdog runs."""
        self._run(
            f"import machine; machine.WDT(timeout={_WATCHDOG_MS}).feed()", "feed the watchdog of"
        )

    def reset(self) -> None:
        """Reset it and release the port."""
        with contextlib.suppress(*self._errors):  # its port may vanish before the answer
            self._transport.exec_raw_no_follow("import machine; machine.reset()")
        self.close()

    def close(self) -> None:
        """Release the port."""
        with contextlib.suppress(*self._errors):
            self._transport.close()
