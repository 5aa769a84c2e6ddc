"""The gamepad: recorded events, a pipe of them, and through uinput where the kernel has it."""

from __future__ import annotations

import contextlib
import os
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.plugins import NOTHING, STOP, Intent, Unusable, drive, hold, step
from gazechair.plugins.gamepad import Gamepad, devices
from gazechair.plugins.gamepad.events import ABS, DROPPED, KEY, REPORT, SYN, PadState, event
from patience import wait_until

A, B = 0x130, 0x131
X, Y, RX, RY, HAT_X, HAT_Y = 0, 1, 3, 4, 16, 17
FULL = -32768
REPORTED = event(SYN, REPORT, 0)


def pad(**settings: Any) -> Gamepad:
    return Gamepad(Gamepad.Settings(**settings))


class FakePad:
    """A gamepad whose events the test sends."""

    def __init__(self) -> None:
        self.data = b""
        self.at: dict[int, int] = {}
        self.gone = False

    def fileno(self) -> int:
        return 99

    def ranges(self) -> dict[int, tuple[int, int]]:
        return {**dict.fromkeys((X, Y, RX, RY), (-32768, 32767)), HAT_X: (-1, 1), HAT_Y: (-1, 1)}

    def positions(self) -> dict[int, int]:
        return self.at

    def read(self, _now_s: float) -> bytes:
        if self.gone:
            raise OSError("No such device")
        data, self.data = self.data, b""
        return data

    def close(self) -> None:
        pass


class Held:
    """A gamepad held by a person."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **settings: Any) -> None:
        self.pads = [FakePad()]

        def open_it() -> FakePad:
            if self.pads[-1].gone:
                raise OSError("no gamepad is plugged in")
            return self.pads[-1]

        monkeypatch.setattr(devices, "opener", lambda _device: open_it)
        self.input = pad(**settings)
        self.now_s = 100.0
        assert self.sense() == NOTHING

    def sense(self, *events: bytes, report: bool = True) -> Intent:
        self.now_s += 0.02
        self.pads[-1].data += b"".join(events) + (REPORTED if events and report else b"")
        return self.input.sense(self.now_s)


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Held]:
    return lambda **settings: Held(monkeypatch, **settings)


def test_the_stick_drives_with_dead_zone_and_curve(held: Callable[..., Held]) -> None:
    hand = held(dead_zone_percent=20, curve=2.0, most_linear=800, most_turn=500)
    assert hand.sense(event(ABS, Y, -32768)) == drive(800, 0)
    assert hand.sense(event(ABS, Y, 0), event(ABS, X, 32767)) == drive(0, -500)
    assert hand.sense(event(ABS, X, -32768)) == drive(0, 500)
    # Half of what is left of the way beyond the dead zone, squared.
    assert hand.sense(event(ABS, X, 0), event(ABS, Y, round(-0.6 * 32768))) == drive(200, 0)
    both = hand.sense(event(ABS, X, 32767), event(ABS, Y, 32767))
    assert both == drive(round(-800 / 2**0.5), round(-500 / 2**0.5))


def test_a_stick_at_the_edge_of_its_dead_zone_does_not_chatter(held: Callable[..., Held]) -> None:
    hand = held(dead_zone_percent=20)
    moves = [
        hand.sense(event(ABS, Y, round(-at * 32768))).moves
        for at in (0.19, 0.21, 0.19, 0.15, 0.13, 0.15, 0.19, 0.21)
    ]
    assert moves == [False, True, True, True, False, False, False, True]


def test_the_other_stick_and_the_cross(held: Callable[..., Held]) -> None:
    hand = held(stick="right")
    assert hand.sense(event(ABS, Y, FULL)) == NOTHING
    assert hand.sense(event(ABS, RY, FULL)) == drive(1000, 0)
    assert hand.sense(event(ABS, HAT_X, -1)) == step("left")
    assert held(cross="hold").sense(event(ABS, HAT_Y, 1)) == hold("backward")
    assert held(cross="off").sense(event(ABS, HAT_Y, 1)) == NOTHING


def test_every_button_stops_but_the_one_that_must_be_held(held: Callable[..., Held]) -> None:
    hand = held()
    push = event(ABS, Y, FULL)
    for button in (A, B, 0x120, 0x13F):
        assert hand.sense(push, event(KEY, button, 1)) == STOP
        assert hand.sense(event(KEY, button, 0)).moves
    hand = held(hold_button=True)
    assert hand.sense(push) == NOTHING
    assert hand.sense(event(KEY, A, 1)) == drive(1000, 0)
    assert hand.sense(event(KEY, B, 1)) == STOP
    assert hand.sense(event(KEY, B, 0), event(KEY, A, 0)) == NOTHING


def test_half_a_report_counts_only_when_it_is_whole(held: Callable[..., Held]) -> None:
    hand = held()
    assert hand.sense(event(ABS, Y, FULL), report=False) == NOTHING
    assert hand.sense(REPORTED, report=False) == drive(1000, 0)


def test_unplugged_it_lets_go_and_plugged_in_it_must_rest_first(held: Callable[..., Held]) -> None:
    hand = held()
    assert hand.sense(event(ABS, Y, FULL)).moves
    hand.pads[-1].gone = True
    assert hand.sense() == NOTHING
    assert hand.input.trouble() == "no gamepad: No such device"
    assert hand.input.fileno() == -1
    for _ in range(60):
        assert hand.sense() == NOTHING
    assert hand.input.trouble() == "no gamepad: no gamepad is plugged in"
    hand.pads.append(FakePad())
    hand.pads[-1].at = {Y: FULL}  # the stick is pushed while it is plugged in
    for _ in range(60):
        assert hand.sense() == NOTHING
    assert hand.input.trouble() == ""
    assert hand.sense(event(ABS, Y, 0)) == NOTHING
    assert hand.sense(event(ABS, Y, FULL)).moves


def test_events_that_the_kernel_dropped_end_what_was_pushed(held: Callable[..., Held]) -> None:
    hand = held()
    assert hand.sense(event(ABS, Y, FULL)).moves
    hand.pads[-1].at = {Y: FULL}
    assert hand.sense(event(SYN, DROPPED, 0)) == NOTHING
    assert hand.sense(event(ABS, Y, FULL)) == NOTHING
    assert hand.sense(event(ABS, Y, 0)) == NOTHING
    assert hand.sense(event(ABS, Y, FULL)).moves


@given(st.binary(max_size=400), st.integers(1, 50))
def test_no_bytes_harm_and_cut_anywhere_they_mean_the_same(data: bytes, size: int) -> None:
    ranges = {X: (-32768, 32767), Y: (0, 255), HAT_X: (1, 1)}
    whole, cut = PadState(ranges), PadState(ranges)
    whole.feed(data)
    for start in range(0, len(data), size):
        cut.feed(data[start : start + size])
    assert (whole.axes, whole.buttons) == (cut.axes, cut.buttons)
    assert all(-1.0 <= at <= 1.0 for at in whole.axes.values())


# -- through a file of the kernel: uinput where there is one, else a named pipe


class Pipe:
    """Another program's end of a named pipe of events."""

    def __init__(self, folder: Path) -> None:
        self.path = str(folder / "pad")
        os.mkfifo(self.path)
        self._fd = -1

    def plug(self) -> None:
        with contextlib.suppress(OSError):  # nobody reads yet
            self._fd = os.open(self.path, os.O_WRONLY | os.O_NONBLOCK)

    def write(self, kind: int, code: int, value: int) -> None:
        os.write(self._fd, event(kind, code, value) + REPORTED)

    @property
    def plugged(self) -> bool:
        return self._fd >= 0

    def unplug(self) -> None:
        os.close(self._fd)


class Uinput:
    """A gamepad that the kernel makes."""

    def __init__(self, _folder: Path) -> None:
        import evdev

        info = evdev.AbsInfo(0, -32768, 32767, 0, 0, 0)
        self._made = evdev.UInput({KEY: [A, B], ABS: [(X, info), (Y, info)]}, name="test pad")
        self.path = str(self._made.device.path)
        self.plugged = True

    def plug(self) -> None:
        pass

    def write(self, kind: int, code: int, value: int) -> None:
        self._made.write(kind, code, value)
        self._made.syn()

    def unplug(self) -> None:
        self._made.close()


@pytest.fixture
def device(tmp_path: Path) -> Iterator[Pipe | Uinput]:
    try:
        yield Uinput(tmp_path)
    except Exception:
        yield Pipe(tmp_path)


def test_events_of_a_device_drive_until_it_is_unplugged(device: Pipe | Uinput) -> None:
    gamepad = pad(device=device.path)
    now_s = 0.0

    def sense() -> Intent:
        nonlocal now_s
        now_s += 0.02
        return gamepad.sense(now_s)

    def opened() -> bool:
        sense()
        device.plug()
        return device.plugged

    wait_until(opened, "it is opened")
    sense()
    device.write(ABS, Y, FULL)
    wait_until(lambda: sense() == drive(1000, 0), "it drives")
    device.write(KEY, B, 1)
    wait_until(lambda: sense() == STOP, "it stops")
    device.unplug()
    wait_until(lambda: sense() == NOTHING, "it lets go")
    assert gamepad.trouble().startswith("no gamepad: ")


# -- the package evdev, here a stand-in with its interface


class Info(types.SimpleNamespace):
    pass


class FakeDevice:
    made: list[str]

    def __init__(self, path: str) -> None:
        if path.endswith("event0"):
            raise PermissionError(13, "Permission denied")
        self.path, self.fd = path, 5
        FakeDevice.made.append(path)

    def capabilities(self, absinfo: bool) -> dict[int, list[Any]]:
        if self.path.endswith("event1"):
            return {KEY: [30], ABS: []}  # a keyboard
        axes: list[Any] = [0, 1]
        if absinfo:
            axes = [(axis, self.absinfo(axis)) for axis in axes]
        return {KEY: [A], ABS: axes}

    def absinfo(self, axis: int) -> Info:
        return Info(value=200 + axis, min=0, max=255)

    def close(self) -> None:
        FakeDevice.made.remove(self.path)


def test_the_first_gamepad_is_found_among_other_devices(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    FakeDevice.made = []
    monkeypatch.setitem(sys.modules, "evdev", Info(InputDevice=FakeDevice))
    monkeypatch.setattr(devices, "FOLDER", tmp_path)
    for name in ("event0", "event1"):
        (tmp_path / name).touch()
    with pytest.raises(OSError, match=r"no gamepad is plugged in; .*event0 is not permitted: add"):
        devices.opener("auto")()
    (tmp_path / "event2").touch()
    found = devices.opener("auto")()
    assert FakeDevice.made == [str(tmp_path / "event2")]
    assert found.ranges() == {0: (0, 255), 1: (0, 255)}
    assert found.positions() == {0: 200, 1: 201}
    assert found.fileno() == 5
    found.close()
    assert FakeDevice.made == []


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "evdev", None)
    with pytest.raises(Unusable, match=r"pip install gazechair\[gamepad\]"):
        pad()
