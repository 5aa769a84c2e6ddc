# CRC-32 (IEEE 802.3, reflected 0xEDB88320) of frames, appended and checked in place.
#
# Seeded by bytes. One interface, two implementations: zlib on CPython; viper on MicroPython,
# because binascii.crc32 allocates there for three values in four (results of 31 bits and more).

import sys

if sys.implementation.name == "micropython":
    from gazelink.crc_board import append, check, fill_seed
else:
    from gazelink.crc_host import append, check, fill_seed

CRC_SIZE = 4


def make_seed(data):
    # The CRC-32 of `data` as 4 new bytes.
    seed = bytearray(CRC_SIZE)
    fill_seed(data, seed)
    return seed


NO_SEED = make_seed(b"")

__all__ = ("CRC_SIZE", "NO_SEED", "append", "check", "fill_seed", "make_seed")
