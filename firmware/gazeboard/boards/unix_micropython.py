# Linux services of the virtual board under MicroPython: a file mapped through ffi.

import os

import ffi
import uctypes

_PROT_READ_WRITE = 3
_MAP_SHARED = 1

getenv = os.getenv
_libc = ffi.open("libc.so.6")
_open = _libc.func("i", "open", "si")
_mmap = _libc.func("P", "mmap", "PLiiil")
_O_RDWR = 2


def map_file(path, size):
    # The first `size` bytes of the file, shared and writable, as a bytearray. OSError when it
    # can't.
    fd = _open(path, _O_RDWR)
    if fd < 0:
        raise OSError("can't open " + path)
    address = _mmap(0, size, _PROT_READ_WRITE, _MAP_SHARED, fd, 0)
    if address in (-1, 0xFFFFFFFF, 0xFFFFFFFFFFFFFFFF):
        raise OSError("can't map " + path)
    return uctypes.bytearray_at(address, size)
