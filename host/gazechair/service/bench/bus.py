"""A Linux I2C bus through smbus2, with an adapter to the interface of Adafruit's drivers."""

from __future__ import annotations

import errno
import importlib
import os
import pwd
from pathlib import Path
from typing import Any, Protocol

from gazechair.service.bench import BenchError


class Bus(Protocol):
    """Plain I2C transfers; OSError when the address does not answer or the bus is stuck."""

    def write(self, address: int, data: bytes) -> None:
        """One write transfer."""

    def read(self, address: int, count: int) -> bytes:
        """One read transfer of `count` bytes."""

    def write_read(self, address: int, data: bytes, count: int) -> bytes:
        """A write and, after a repeated start, a read of `count` bytes."""

    def close(self) -> None:
        """Release the bus."""


class LinuxBus:
    """Implements Bus on /dev/i2c-N."""

    def __init__(self, number: int, devices: Path = Path("/dev")) -> None:
        """Raises BenchError with the reason and what to do."""
        try:
            smbus2: Any = importlib.import_module("smbus2")
        except ImportError:
            raise BenchError(
                "smbus2 is not installed; run `pip install 'gazechair[bench]'`"
            ) from None
        self._message = smbus2.i2c_msg
        path = devices / f"i2c-{number}"
        try:
            self._bus = smbus2.SMBus(str(path))
        except OSError as error:
            raise BenchError(_why(path, devices, error)) from None

    def write(self, address: int, data: bytes) -> None:
        """One write transfer."""
        self._bus.i2c_rdwr(self._message.write(address, data))

    def read(self, address: int, count: int) -> bytes:
        """One read transfer of `count` bytes."""
        message = self._message.read(address, count)
        self._bus.i2c_rdwr(message)
        return bytes(message)

    def write_read(self, address: int, data: bytes, count: int) -> bytes:
        """A write and, after a repeated start, a read of `count` bytes."""
        message = self._message.read(address, count)
        self._bus.i2c_rdwr(self._message.write(address, data), message)
        return bytes(message)

    def close(self) -> None:
        """Release the bus."""
        self._bus.close()


def _why(path: Path, devices: Path, error: OSError) -> str:
    if error.errno == errno.ENOENT:
        numbers = sorted(int(p.name[4:]) for p in devices.glob("i2c-*") if p.name[4:].isdigit())
        there = ", ".join(map(str, numbers))
        return f"{path} is not there; " + (
            f"the buses here are {there}: give one as --bus"
            if numbers
            else "run `sudo modprobe i2c-dev`, or plug in the I2C adapter"
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        user = pwd.getpwuid(os.geteuid()).pw_name  # not $USER: the installed command changes it
        return (
            f"{path} is not permitted to this user; run `sudo apt install i2c-tools`,"
            f" `sudo usermod -aG i2c {user}`, and log in again"
        )
    return f"{path} cannot be opened ({error.strerror})"


def answers(bus: Bus, address: int) -> bool:
    """Whether something at `address` acknowledges a read of one byte."""
    try:
        bus.read(address, 1)
    except OSError:
        return False
    return True


class BusioShape:
    """A Bus with the interface of busio.I2C, without Blinka's detection of the computer."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus

    def try_lock(self) -> bool:
        """Always succeeds: there is no other user."""
        return True

    def unlock(self) -> None:
        """Nothing was locked."""

    def writeto(self, address: int, buffer: Any, *, start: int = 0, end: int | None = None) -> None:
        """Write buffer[start:end]."""
        self._bus.write(address, bytes(buffer[start:end]))

    def readfrom_into(
        self, address: int, buffer: Any, *, start: int = 0, end: int | None = None
    ) -> None:
        """Fill buffer[start:end]."""
        end = len(buffer) if end is None else end
        buffer[start:end] = self._bus.read(address, end - start)

    def writeto_then_readfrom(
        self,
        address: int,
        out_buffer: Any,
        in_buffer: Any,
        *,
        out_start: int = 0,
        out_end: int | None = None,
        in_start: int = 0,
        in_end: int | None = None,
    ) -> None:
        """Write out_buffer[...], then fill in_buffer[...] after a repeated start."""
        in_end = len(in_buffer) if in_end is None else in_end
        data = self._bus.write_read(
            address, bytes(out_buffer[out_start:out_end]), in_end - in_start
        )
        in_buffer[in_start:in_end] = data
