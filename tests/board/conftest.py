"""Boards for these tests: emulated Teensys, or with --board PORT the one there, real or not."""

import contextlib
import shutil
from collections.abc import Hashable, Iterator
from pathlib import Path

import pytest

from gazechair.commissioning import board_settings
from gazechair.service import board_connection
from gazechair.service.calibrate import heading
from gazechair.service.flash import Flasher, command, repl, tree
from gazedemo.sim_control import SimControl
from gazelink import codes
from liveboard import LIMIT_S, NOBODY_S, EmulatedLiveBoard, Flashed, LiveBoard
from remembered import remembered

SETTING_S = 3.0  # it takes a third of a second of the board's own time


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """A board that is there already takes no injected faults, and no factory-new flash."""
    if config.getoption("--board") is None:
        return
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents and "m7" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.skip(reason="needs faults that only an emulation has"))


@pytest.fixture(scope="session", autouse=True)
def patient() -> Iterator[None]:
    """The host waits for an answer as long as this machine may stall, two boards side by side.

    What comes, comes no later: only a test that fails takes longer.
    """
    with pytest.MonkeyPatch.context() as patch:
        for module in (command, heading):
            for name in ("_HELLO_S", "_MAINTENANCE_S", "_START_S"):
                patch.setattr(module, name, LIMIT_S)
        patch.setattr(repl, "_TIMEOUT_S", LIMIT_S)
        patch.setattr(board_connection, "_CONNECT_S", LIMIT_S)
        # Asked again while it still writes its flash, a slow board loses its session by that.
        patch.setattr(board_settings, "_ANSWER_S", SETTING_S)
        patch.setattr(board_settings, "_TRIES", int(LIMIT_S / SETTING_S))
        yield


@pytest.fixture(scope="session", autouse=True)
def built_once() -> Iterator[None]:
    """The same sources are compiled once for all tests: that takes longer than copying them."""

    def key(sources: tree.Sources, compile_file: tree.Compile | None) -> Hashable:
        texts = tuple((path, file.read_bytes()) for path, file in sources.files.items())
        return texts, sources.main.read_bytes(), compile_file is None

    with remembered(tree, "build", key):
        yield


@pytest.fixture(scope="session")
def firmware_sources(tmp_path_factory: pytest.TempPathFactory) -> tree.Sources:
    """A copy of this checkout's firmware."""
    found = tree.find_sources()
    folder = tmp_path_factory.mktemp("sources")
    files = {}
    for path, file in found.files.items():
        files[path] = folder / path
        files[path].parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, files[path])
    shutil.copyfile(found.main, folder / "main.py")
    return tree.Sources(files, folder / "main.py")


@pytest.fixture(scope="session")
def flashed(
    m7: Path,
    patient: None,
    firmware_sources: tree.Sources,
    tmp_path_factory: pytest.TempPathFactory,
) -> Flashed:
    """What the flashing of a new board says, and its flash memory then."""
    printed: list[str] = []
    board = EmulatedLiveBoard(m7, tmp_path_factory.mktemp("flashed"), None)
    board.start()
    try:
        board.start_background()
        try:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(tree, "find_sources", lambda: firmware_sources)
                patch.setattr(command, "_HELLO_S", NOBODY_S)
                Flasher(printed.append).flash(str(board.host.path), dry_run=False, force=False)
        finally:
            board.stop_background()
        return Flashed("\n".join(printed), board.flash)
    finally:
        board.stop()


@pytest.fixture
def emulated(flashed: Flashed, m7: Path, tmp_path: Path) -> Iterator[EmulatedLiveBoard]:
    """The firmware just switched on, on an emulated Teensy of its own."""
    board = EmulatedLiveBoard(m7, tmp_path, flashed.flash)
    board.start()
    try:
        yield board
        assert board.host.safety != codes.ARMED or board.world.relay.closed
    finally:
        board.stop()


@pytest.fixture
def board(request: pytest.FixtureRequest) -> Iterator[LiveBoard]:
    """The board at --board PORT, its relay held open; else an emulated one of its own."""
    port = request.config.getoption("--board")
    if port is None:
        yield request.getfixturevalue("emulated")
        return
    # A Teensy's port is a USB device's; a terminal without a device is a simulator's.
    simulated = Path(port).resolve().parent == Path("/dev/pts")
    there = LiveBoard(Path(port), simulated)
    try:
        with relay_held_open(Path(port)) if simulated else contextlib.nullcontext():
            yield there
    finally:
        there.stop()


@contextlib.contextmanager
def relay_held_open(port: Path) -> Iterator[None]:
    """In the simulator (`python -m gazesim`) whose board's port this is; a real one is by hand."""
    control = SimControl(port.parent / "control")
    try:
        control.do("inject", fault="relay_stuck_open")
        try:
            yield
        finally:
            control.do("clear", fault="relay_stuck_open")
    finally:
        control.close()
