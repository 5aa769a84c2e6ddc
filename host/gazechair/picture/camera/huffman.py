"""The Huffman tables that browsers need and many USB cameras omit from their Motion-JPEG.

Source: ITU-T T.81 annex K.3, the typical tables, which Motion-JPEG assumes.
"""

from __future__ import annotations

_DHT = 0xC4
_SOS = 0xDA
_LUMINANCE_DC = "00 00010501010101010100000000000000 000102030405060708090a0b"
_CHROMINANCE_DC = "01 00030101010101010101010000000000 000102030405060708090a0b"
_LUMINANCE_AC = """
10 0002010303020403050504040000017d
01020300041105122131410613516107227114328191a1082342b1c11552d1f02433627282090a161718191a2526
2728292a3435363738393a434445464748494a535455565758595a636465666768696a737475767778797a838485
868788898a92939495969798999aa2a3a4a5a6a7a8a9aab2b3b4b5b6b7b8b9bac2c3c4c5c6c7c8c9cad2d3d4d5d6
d7d8d9dae1e2e3e4e5e6e7e8e9eaf1f2f3f4f5f6f7f8f9fa"""
_CHROMINANCE_AC = """
11 00020102040403040705040400010277
0001020311040521310612415107617113223281081442 91a1b1c109233352f0156272d10a162434e125f1171819
1a262728292a35363738393a434445464748494a535455565758595a636465666768696a737475767778797a8283
8485868788898a92939495969798999aa2a3a4a5a6a7a8a9aab2b3b4b5b6b7b8b9bac2c3c4c5c6c7c8c9cad2d3d4
d5d6d7d8d9dae2e3e4e5e6e7e8e9eaf2f3f4f5f6f7f8f9fa"""


def _segment(*tables: str) -> bytes:
    body = b"".join(bytes.fromhex(table) for table in tables)
    return bytes((0xFF, _DHT)) + (len(body) + 2).to_bytes(2, "big") + body


TABLES = _segment(_LUMINANCE_DC, _LUMINANCE_AC, _CHROMINANCE_DC, _CHROMINANCE_AC)


def with_tables(jpeg: bytes) -> bytes:
    """`jpeg` with the typical tables inserted before its scan, if it has none; else unchanged.

    Data that does not parse as JPEG segments is returned unchanged.
    """
    at = 2
    while at + 4 <= len(jpeg) and jpeg[at] == 0xFF:
        marker = jpeg[at + 1]
        if marker == _DHT:
            return jpeg
        if marker == _SOS:
            return jpeg[:at] + TABLES + jpeg[at:]
        at += 2 + int.from_bytes(jpeg[at + 2 : at + 4], "big")
    return jpeg
