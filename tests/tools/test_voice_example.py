"""docs/examples/voice, installed as by a stranger: it keeps the contract and drives by speech."""

from __future__ import annotations

import fcntl
import os
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import gazesetup
from gazechair.plugins.found import Found
from gazecontract.chair import PluginChair
from gazecontract.paced import Paced

pytest.importorskip("pocketsphinx")
pytest.importorskip("espeakng_loader")

PLACE = gazesetup.ROOT / "docs" / "examples" / "voice"
RUN_S = 240.0
FOUND = Found("input", "voice", "gazechair_voice.voice:Voice", "gazechair-voice")
SLICE_BYTES = 640  # 20 ms
PATIENCE_S = 30.0  # of real time, for a machine that stands still for a while
TRIES = 5
pytestmark = pytest.mark.xdist_group("wheel")


@pytest.fixture(scope="module")
def environment(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The wheel, and the package beside it, built from a copy: building leaves files behind."""
    folder = tmp_path_factory.mktemp("voice")
    copy = folder / "source"
    copy.mkdir()
    for name in ("pyproject.toml", *(f.name for f in (PLACE / "gazechair_voice").glob("*.py"))):
        there = Path(name) if name == "pyproject.toml" else Path("gazechair_voice", name)
        (copy / there).parent.mkdir(exist_ok=True)
        (copy / there).write_bytes((PLACE / there).read_bytes())
    pip = ("-m", "pip", "install", "--no-deps", "--disable-pip-version-check", "--target")
    env = {**os.environ, "PYTHONPATH": str(installed), "XDG_CACHE_HOME": str(folder / "cache")}
    run(env, *pip, str(folder / "site"), str(copy))
    return {**env, "PYTHONPATH": f"{installed}{os.pathsep}{folder / 'site'}"}


def run(env: dict[str, str], *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words], env=env, capture_output=True, text=True, timeout=RUN_S
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_keeps_the_contract(environment: dict[str, str]) -> None:
    output = run(environment, "-m", "gazechair", "plugin", "check", "input.voice")
    assert "ok    armed, it drives the chair: wipers after" in output
    assert "FAILS" not in output


def test_its_own_tests(environment: dict[str, str]) -> None:
    run(environment, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(PLACE / "tests"))


class Room:
    """A microphone: silence, and what is spoken into it, 20 ms for each question.

    The recogniser works in its own time, the chair in virtual time: each question waits until the
    sound before it has been read, and a word that got lost between the two is spoken again.
    """

    def __init__(self, path: Path, process: Paced) -> None:
        self._process = process
        self._fd = os.open(path, os.O_RDWR)
        self.sound = b""

    def ask(self, word: dict[str, object]) -> bytes:
        """The plug-in's answer; the thread that recognises has read all sound before it."""
        received, self.sound = self.sound[:SLICE_BYTES], self.sound[SLICE_BYTES:]
        os.write(self._fd, received.ljust(SLICE_BYTES, b"\0"))
        end_s = time.monotonic() + PATIENCE_S
        while self._unread():
            assert time.monotonic() < end_s, "nobody listens"
            time.sleep(0.001)
        return self._process.ask(word)

    def _unread(self) -> int:
        """Bytes that the plug-in has not read yet."""
        waiting = fcntl.ioctl(self._fd, termios.FIONREAD, bytes(4))
        return int(struct.unpack("i", waiting)[0])

    def speak_until(
        self, chair: PluginChair, sound: bytes, condition: Callable[[], bool], limit_ms: int
    ) -> None:
        """`sound`, again after each `limit_ms` in which `condition` did not come, a few times."""
        for left in reversed(range(TRIES)):
            self.sound = sound
            try:
                chair.until(condition, limit_ms)
                return
            except AssertionError:
                if not left:
                    raise

    def close(self) -> None:
        """Nobody speaks any more."""
        os.close(self._fd)


@pytest.fixture
def room(
    environment: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Room]:
    for folder in environment["PYTHONPATH"].split(os.pathsep):
        monkeypatch.syspath_prepend(folder)
    monkeypatch.syspath_prepend(str(PLACE / "tests"))
    pipe = tmp_path / "microphone"
    os.mkfifo(pipe)
    with Paced(FOUND, {"source": str(pipe)}) as process:
        room = Room(pipe, process)
        yield room
        room.close()


def test_spoken_words_drive_the_chair_and_stop_it(room: Room) -> None:
    from speech import in_a_room, say  # type: ignore[import-not-found]

    chair = PluginChair("input", "voice", room.ask)
    chair.ready()
    chair.sit()
    room.sound = in_a_room(say("forward"))
    chair.run(2500)
    assert chair.harmless()  # a word never switches driving on
    chair.arm()
    chair.run(1000)
    here = chair.world.chair
    stood = (here.x_m, here.heading_deg)
    for other in ("good morning", "battery"):
        room.sound = in_a_room(say(other))
        chair.run(2500)
        assert (here.x_m, here.heading_deg) == pytest.approx(stood, abs=0.01)
    left = in_a_room(say("left"))
    room.speak_until(chair, left, lambda: bool(here.heading_deg > stood[1] + 3.0), 8000)
    chair.until(lambda: bool(chair.neutral()), 8000)
    chair.run(1500)
    turned = here.heading_deg
    assert turned > stood[1] + 5.0
    room.speak_until(chair, in_a_room(say("forward")), lambda: not chair.neutral(), 8000)
    stop = in_a_room(say("stop"), before_s=0.3)
    room.speak_until(
        chair, stop, lambda: bool(chair.value and chair.value.intent.do == "stop"), 4000
    )
    chair.run(20)
    assert chair.neutral()
