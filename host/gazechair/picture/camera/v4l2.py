"""A Video4Linux camera that provides JPEGs: uses only ioctls and mapped buffers.

Source of numbers and layouts: linux/videodev2.h on 64-bit machines (a test checks with the
compiler).
"""

from __future__ import annotations

import errno
import fcntl
import mmap
import os
import select
import struct
from dataclasses import dataclass

from gazechair.picture.camera import CameraError

QUERYCAP = 0x80685600
S_FMT = 0xC0D05605
REQBUFS = 0xC0145608
QUERYBUF = 0xC0585609
QBUF = 0xC058560F
DQBUF = 0xC0585611
STREAMON = 0x40045612
S_PARM = 0xC0CC5616

CAPABILITY_SIZE = 104
FORMAT_SIZE = 208
BUFFER_SIZE = 88
PARM_SIZE = 204
_CAPABILITIES = struct.Struct("<II")  # capabilities, device_caps
_CAPABILITIES_AT = 84
_PIX = struct.Struct("<III")  # width, height, pixelformat
_PIX_AT = 8
_FRAME_TIME = struct.Struct("<II")  # numerator, denominator
_FRAME_TIME_AT = 12
_REQUEST = struct.Struct("<III8x")  # count, type, memory
_BYTES_USED_AT = 8
_FLAGS_AT = 12
_TIMESTAMP = struct.Struct("<qq")  # s, us
_TIMESTAMP_AT = 24
_MEMORY_AT = 60
_OFFSET_AT = 64
_LENGTH_AT = 72

_CAPTURE = 1  # V4L2_BUF_TYPE_VIDEO_CAPTURE, and the capability's bit
_MMAP = 1
_STREAMING = 0x04000000
_DEVICE_CAPS = 0x80000000
_FLAG_ERROR = 0x40
_TIME_MASK = 0xE000
_TIME_MONOTONIC = 0x2000
MJPEG = 0x47504A4D
_BUFFERS = 2  # one is filled while the other is read: more would only add delay


@dataclass(frozen=True)
class Picture:
    """A buffer's picture and its CLOCK_MONOTONIC time, s; None: another clock."""

    jpeg: bytes
    taken_s: float | None


class Capture:
    """One camera, streaming from construction to close(). Raises CameraError."""

    def __init__(self, device: str, width: int, height: int, rate_hz: int) -> None:
        self.device = device
        self._maps: list[mmap.mmap] = []
        try:
            self._fd = os.open(device, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise CameraError(f"{device} can't be opened: {error.strerror}") from error
        try:
            self._begin(width, height, rate_hz)
        except CameraError:
            self.close()
            raise
        except OSError as error:
            self.close()
            if error.errno == errno.EBUSY:
                raise CameraError(f"{device} is in use by another program") from error
            raise CameraError(f"{device} can't be set up: {error.strerror}") from error

    def _begin(self, width: int, height: int, rate_hz: int) -> None:
        capability = bytearray(CAPABILITY_SIZE)
        self._ioctl(QUERYCAP, capability)
        whole, of_node = _CAPABILITIES.unpack_from(capability, _CAPABILITIES_AT)
        can = of_node if whole & _DEVICE_CAPS else whole
        if not can & _CAPTURE or not can & _STREAMING:
            raise CameraError(f"{self.device} is no camera that streams; try the next /dev/video")
        form = bytearray(FORMAT_SIZE)
        form[0] = _CAPTURE
        _PIX.pack_into(form, _PIX_AT, width, height, MJPEG)
        self._ioctl(S_FMT, form)  # the driver returns the format that it uses
        self.width, self.height, pixels = _PIX.unpack_from(form, _PIX_AT)
        if pixels != MJPEG:
            raise CameraError(f"{self.device} makes no MJPEG; use a camera that does")
        parm = bytearray(PARM_SIZE)
        parm[0] = _CAPTURE
        _FRAME_TIME.pack_into(parm, _FRAME_TIME_AT, 1, rate_hz)
        self._ioctl(S_PARM, parm)
        request = bytearray(_REQUEST.pack(_BUFFERS, _CAPTURE, _MMAP))
        self._ioctl(REQBUFS, request)
        for index in range(request[0]):
            buffer = self._buffer(index)
            self._ioctl(QUERYBUF, buffer)
            (offset,) = struct.unpack_from("<I", buffer, _OFFSET_AT)
            (length,) = struct.unpack_from("<I", buffer, _LENGTH_AT)
            self._maps.append(mmap.mmap(self._fd, length, offset=offset))
            self._ioctl(QBUF, buffer)
        self._ioctl(STREAMON, bytearray(struct.pack("<I", _CAPTURE)))

    def _buffer(self, index: int) -> bytearray:
        buffer = bytearray(BUFFER_SIZE)
        struct.pack_into("<II", buffer, 0, index, _CAPTURE)
        struct.pack_into("<I", buffer, _MEMORY_AT, _MMAP)
        return buffer

    def read(self, timeout_s: float) -> Picture | None:
        """The newest picture; None: none in time, or damaged. Raises CameraError when lost."""
        try:
            ready, _, _ = select.select([self._fd], [], [], timeout_s)
            buffer = self._buffer(0)
            if not ready:
                return None
            self._ioctl(DQBUF, buffer)
            index, _ = struct.unpack_from("<II", buffer, 0)
            (used,) = struct.unpack_from("<I", buffer, _BYTES_USED_AT)
            (flags,) = struct.unpack_from("<I", buffer, _FLAGS_AT)
            seconds, microseconds = _TIMESTAMP.unpack_from(buffer, _TIMESTAMP_AT)
            jpeg = bytes(self._maps[index][:used])
            self._ioctl(QBUF, self._buffer(index))
        except OSError as error:
            raise CameraError(f"{self.device} is gone: {error.strerror}") from error
        if flags & _FLAG_ERROR:
            return None
        monotonic = flags & _TIME_MASK == _TIME_MONOTONIC
        return Picture(jpeg, seconds + microseconds / 1e6 if monotonic else None)

    def close(self) -> None:
        """Release the camera."""
        for mapped in self._maps:
            mapped.close()
        os.close(self._fd)  # ends the stream

    def _ioctl(self, request: int, argument: bytearray) -> None:
        fcntl.ioctl(self._fd, request, argument)
