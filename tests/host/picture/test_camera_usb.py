"""USB and OAK cameras against stand-ins for the kernel and depthai; MJPEG tables restored."""

from __future__ import annotations

import errno
import io
import os
import re
import shutil
import struct
import subprocess
import sys
import types
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from gazechair.base.latest_value import Latest
from gazechair.picture.camera import CameraError, oak, usb, v4l2
from gazechair.picture.camera.huffman import TABLES, with_tables
from gazechair.picture.camera.record import Frame

HEADER = Path("/usr/include/linux/videodev2.h")
CONSTANTS = {
    "VIDIOC_QUERYCAP": v4l2.QUERYCAP,
    "VIDIOC_S_FMT": v4l2.S_FMT,
    "VIDIOC_REQBUFS": v4l2.REQBUFS,
    "VIDIOC_QUERYBUF": v4l2.QUERYBUF,
    "VIDIOC_QBUF": v4l2.QBUF,
    "VIDIOC_DQBUF": v4l2.DQBUF,
    "VIDIOC_STREAMON": v4l2.STREAMON,
    "VIDIOC_S_PARM": v4l2.S_PARM,
    "V4L2_PIX_FMT_MJPEG": v4l2.MJPEG,
    "sizeof(struct v4l2_capability)": v4l2.CAPABILITY_SIZE,
    "sizeof(struct v4l2_format)": v4l2.FORMAT_SIZE,
    "sizeof(struct v4l2_buffer)": v4l2.BUFFER_SIZE,
    "sizeof(struct v4l2_streamparm)": v4l2.PARM_SIZE,
}


def picture(size: tuple[int, int] = (64, 48)) -> bytes:
    out = io.BytesIO()
    Image.effect_noise(size, 50).convert("RGB").save(out, "JPEG")
    return out.getvalue()


def bare(jpeg: bytes) -> bytes:
    """`jpeg` without its Huffman tables, as many cameras send it."""
    out, at = jpeg[:2], 2
    while jpeg[at + 1] != 0xDA:
        end = at + 2 + int.from_bytes(jpeg[at + 2 : at + 4], "big")
        if jpeg[at + 1] != 0xC4:
            out += jpeg[at:end]
        at = end
    return out + jpeg[at:]


# -- tables ----------------------------------------------------------------------------------------


def test_left_out_tables_are_put_back() -> None:
    whole = picture()
    assert len(TABLES) == 420  # four tables in one segment
    mended = with_tables(bare(whole))
    assert Image.open(io.BytesIO(mended)).tobytes() == Image.open(io.BytesIO(whole)).tobytes()


def test_a_picture_with_tables_and_what_is_none_stay_as_they_are() -> None:
    whole = picture()
    assert with_tables(whole) is whole
    for junk in (b"", b"\xff\xd8", b"\xff\xd8\xff\xe0\x00", b"\xff\xd8nonsense\xff\xd9"):
        assert with_tables(junk) is junk


# -- the kernel's side -----------------------------------------------------------------------------


def test_numbers_and_sizes_are_those_of_the_kernels_header(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None or not HEADER.exists():
        # Without a compiler at least the size inside each request number must be the structure's.
        sizes = {v4l2.QUERYCAP: 104, v4l2.S_FMT: 208, v4l2.QBUF: 88, v4l2.S_PARM: 204}
        assert all(request >> 16 & 0x3FFF == size for request, size in sizes.items())
        return
    lines = "".join(f'printf("%lx\\n", (unsigned long)({name}));' for name in CONSTANTS)
    source = tmp_path / "numbers.c"
    source.write_text(
        f"#include <stdio.h>\n#include <linux/videodev2.h>\nint main(void){{{lines}return 0;}}"
    )
    subprocess.run([compiler, "-o", tmp_path / "numbers", source], check=True, timeout=60)
    done = subprocess.run([tmp_path / "numbers"], check=True, capture_output=True, timeout=60)
    assert [int(line, 16) for line in done.stdout.split()] == list(CONSTANTS.values())


class Kernel:
    """A driver with two buffers; `pictures` come one by one, each with its flags."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        self.node = folder / "video0"
        self.node.write_bytes(bytes(2 * 65536))
        self.pictures: list[tuple[bytes, int]] = []
        self.pixels = v4l2.MJPEG
        self.can = 0x04000001
        self.busy = False
        self.streaming = False
        self.queued: list[int] = []
        monkeypatch.setattr(v4l2.fcntl, "ioctl", self.ioctl)
        monkeypatch.setattr(v4l2.select, "select", self.select)

    def select(self, read: list[int], *_rest: Any) -> tuple[list[int], list[int], list[int]]:
        return (read if self.pictures else []), [], []

    def ioctl(self, fd: int, request: int, argument: bytearray) -> int:
        if request == v4l2.QUERYCAP:
            struct.pack_into("<II", argument, 84, 0x84200001, self.can)
        elif request == v4l2.S_FMT:
            if self.busy:
                raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))
            width, height, pixels = struct.unpack_from("<III", argument, 8)
            assert (argument[0], pixels) == (1, v4l2.MJPEG)
            struct.pack_into("<III", argument, 8, min(width, 1280), min(height, 720), self.pixels)
        elif request == v4l2.QUERYBUF:
            struct.pack_into("<I", argument, 64, argument[0] * 65536)
            struct.pack_into("<I", argument, 72, 65536)
        elif request == v4l2.QBUF:
            self.queued.append(argument[0])
        elif request == v4l2.DQBUF:
            if not self.pictures:
                raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
            jpeg, flags = self.pictures.pop(0)
            index = self.queued.pop(0)
            with self.node.open("r+b") as device:
                device.seek(index * 65536)
                device.write(jpeg)
            struct.pack_into("<IIII", argument, 0, index, 1, len(jpeg), flags)
            struct.pack_into("<qq", argument, 24, 12, 500_000)
        elif request == v4l2.STREAMON:
            self.streaming = True
        return 0


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Kernel:
    return Kernel(monkeypatch, tmp_path)


def opened(kernel: Kernel) -> v4l2.Capture:
    return v4l2.Capture(str(kernel.node), 640, 480, 15)


def test_each_picture_comes_with_the_time_it_was_taken(kernel: Kernel) -> None:
    camera = opened(kernel)
    assert kernel.streaming
    kernel.pictures = [(b"\xff\xd8one\xff\xd9", 0x2000), (b"\xff\xd8two\xff\xd9", 0)]
    first, second = camera.read(0), camera.read(0)
    assert first == v4l2.Picture(b"\xff\xd8one\xff\xd9", 12.5)
    assert second == v4l2.Picture(b"\xff\xd8two\xff\xd9", None)  # another clock: not believed
    assert sorted(kernel.queued) == [0, 1]  # both buffers are the camera's again
    camera.close()


def test_a_damaged_picture_is_skipped_and_silence_is_no_picture(kernel: Kernel) -> None:
    camera = opened(kernel)
    kernel.pictures = [(b"\xff\xd8half", 0x2040)]
    assert camera.read(0) is None
    assert camera.read(0) is None
    camera.close()


def test_a_pulled_camera_is_said(kernel: Kernel, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = opened(kernel)
    monkeypatch.setattr(v4l2.select, "select", lambda read, *_: (read, [], []))
    with pytest.raises(CameraError, match="is gone: No such device"):
        camera.read(0)
    camera.close()


def test_what_can_not_be_used_says_why(kernel: Kernel) -> None:
    kernel.pixels = 0x56595559
    with pytest.raises(CameraError, match="makes no MJPEG"):
        opened(kernel)
    kernel.busy = True
    with pytest.raises(CameraError, match="in use by another program"):
        opened(kernel)
    kernel.can = 0
    with pytest.raises(CameraError, match="no camera that streams"):
        opened(kernel)
    with pytest.raises(CameraError, match="can't be opened: No such file"):
        v4l2.Capture(str(kernel.node) + "9", 640, 480, 15)


def test_devices_are_tried_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    for name in ("video10", "video2", "video0", "videox", "media0"):
        (tmp_path / name).touch()
    assert [re.sub(".*/", "", name) for name in usb.find(tmp_path)] == [
        "video0",
        "video2",
        "video10",
    ]


def test_whole_pictures_reach_the_slot_without_padding_and_with_tables(kernel: Kernel) -> None:
    whole = picture()
    newest: Latest[Frame] = Latest()
    kernel.pictures = [(bare(whole) + bytes(100), 0x2000)]
    real_select = v4l2.select.select

    def then_gone(read: list[int], *rest: Any) -> Any:
        return real_select(read, *rest) if kernel.pictures else (read, [], [])

    v4l2.select.select = then_gone  # restored by the fixture's monkeypatch
    with pytest.raises(CameraError, match="gone"):
        usb.read(str(kernel.node), 640, 480, 15, newest)
    frame = newest.get()
    assert frame is not None
    assert frame.jpeg == with_tables(bare(whole))
    assert frame.acquired_monotonic == 12.5


# -- OAK -------------------------------------------------------------------------------------------


class Packet:
    def __init__(self, jpeg: bytes, taken_s: float) -> None:
        self.jpeg = jpeg
        self.taken_s = taken_s

    def getData(self) -> bytes:
        return self.jpeg

    def getTimestamp(self) -> timedelta:
        return timedelta(seconds=self.taken_s)


def fake_depthai(packets: list[Packet | None], made: dict[str, Any]) -> types.ModuleType:
    class Node:
        def build(self, *args: Any, **words: Any) -> Node:
            made.setdefault("built", []).append((args, words))
            return self

        def requestOutput(self, *args: Any, **words: Any) -> str:
            made["asked"] = (args, words)
            return "raw"

        @property
        def bitstream(self) -> Node:
            return self

        def createOutputQueue(self, **words: Any) -> Node:
            made["queue"] = words
            return self

        def tryGet(self) -> Packet | None:
            return packets.pop(0)

    class Pipeline:
        def __enter__(self) -> Pipeline:
            return self

        def __exit__(self, *_args: object) -> None:
            made["closed"] = True

        def create(self, _node: Any) -> Node:
            return Node()

        def start(self) -> None:
            pass

        def isRunning(self) -> bool:
            return bool(packets)

    module: Any = types.ModuleType("depthai")
    module.Pipeline = Pipeline
    module.node = types.SimpleNamespace(Camera=Node, VideoEncoder=Node)
    module.CameraBoardSocket = types.SimpleNamespace(CAM_A="A")
    module.ImgFrame = types.SimpleNamespace(Type=types.SimpleNamespace(NV12="NV12"))
    profile = types.SimpleNamespace(MJPEG="MJPEG")
    module.VideoEncoderProperties = types.SimpleNamespace(Profile=profile)
    return module


def test_the_oaks_own_jpegs_reach_the_slot(monkeypatch: pytest.MonkeyPatch) -> None:
    made: dict[str, Any] = {}
    packets = [None, Packet(b"\xff\xd8a\xff\xd9", 3.0), Packet(b"broken", 4.0)]
    monkeypatch.setitem(sys.modules, "depthai", fake_depthai(packets, made))
    newest: Latest[Frame] = Latest()
    with pytest.raises(CameraError, match="has stopped"):
        oak.read(800, 600, 12, newest)
    assert newest.get() == Frame(b"\xff\xd8a\xff\xd9", 3.0)
    assert made["asked"] == (((800, 600), "NV12"), {"fps": 12.0})
    assert made["queue"] == {"maxSize": 1, "blocking": False}
    assert made["closed"]


def test_without_depthai_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "depthai", None)
    with pytest.raises(CameraError, match=r"gazechair\[oak\]"):
        oak.read(640, 480, 15, Latest())
