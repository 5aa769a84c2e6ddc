# Known answers of the wire, worked out with tests/protocol/wire_reference.py, for both Pythons.

# CRC-32 of b"123456789", the check value of every catalogue of CRCs.
CRC_CHECK = 0xCBF43926

# (data, seed as its 4 bytes, result as its 4 bytes): plain values, and values above 31 bits.
CRCS = (
    (b"123456789", "00000000", "2639f4cb"),
    (b"", "00000000", "00000000"),
    (b"", "78563412", "78563412"),
    (b"\x00", "00000000", "8def02d2"),
    (b"\xff\xff\xff\xff", "00000000", "ffffffff"),
    (b"gazechair", "78563412", "af434a7b"),
    (b"\x00" * 58, "ffffffff", "ffffffff"),
)

# The hash of the message table. Another value means that the wire changed: old boards and new hosts
# will refuse each other, as they must. Change it here only when that is meant.
SCHEMA_HASH = "e934067c"

# (session, boot, nonce, epoch, seed) under that hash.
SEEDS = ((0xBEEF, 0x0102, "01020304", 0x10203, "f9ed52ce"),)

# Seed of the frames below; fixed, so that they stay when the table grows. Frozen ones ignore it.
FRAME_SEED = "78563412"


class OneSeed:
    # A session whose seed never changes.
    def __init__(self, seed):
        self._seed = seed

    def seed(self, stamp_ms):
        return self._seed


# (message, seq, stamp_ms, values in table order, frame)
FRAMES = (
    (
        "hello",
        250,
        65280,
        (1, 3, 0x6C0D8E99, 0xBEEF, 1, 0, 1, 0, b"gazechair" + bytes(7)),
        "0301fa0bff0103998e0d6cefbe010102010a67617a65636861697201010101010105ddfa151000",
    ),
    (
        "fault",
        251,
        0,
        (40, b"OSError: 19" + bytes(29)),
        (
            "0302fb010d284f534572726f723a203139"
            "01010101010101010101010101010101010101010101010101010101059cfc26b000"
        ),
    ),
    (
        "nonce",
        252,
        2,
        (0xBEEF, b"\x01\x00\x03\x04", 0x10203),
        "0404fc0204efbe0106030403020105e95bd35500",
    ),
    ("maintenance", 252, 1, (0x11A7C0DE, 1, 0), "0403fc0106dec0a71101055bafb7a100"),
    (
        "command",
        253,
        4660,
        (1, 1, 255, 1, 300, -1000, 1000, 700, 2000),
        "1710fd34120101ff012c0118fce803bc02d007aec97bb900",
    ),
    ("order", 254, 65535, (1, 7, 1), "0c11feffff01070182c959f500"),
    (
        "clearance",
        255,
        256,
        (0b1010, 0b0100, 1, 65535, 0, 5760, 48, 65535, 0b00100001, bytes(range(37)) + b"\xff"),
        (
            "0312ff07010a0401ffff010480163004ffff212a0102030405060708090a0b0c0d0e"
            "0f101112131415161718191a1b1c1d1e1f2021222324ff80a9ae7d00"
        ),
    ),
    ("bypass", 9, 500, (255, 300), "0c1609f401ff2c019b2d2ae000"),
    ("trace_request", 10, 501, (1,), "0a170af50101e82a1eda00"),
    ("supervision", 12, 503, (255, 2, 65535), "0d180cf701ff02ffff0388f7e100"),
    ("ping", 0, 255, (0x0001, 0xFFFE), "021302ff020107feff47d128d600"),
    (
        "state",
        1,
        42,
        (0x12, 5, 0, 0, 0x80000001, 5759, -1000, 12, 9, 0b11100100),
        "0420012a0312050102010107807f1618fc0c0709e4ea811b2700",
    ),
    (
        "stats",
        2,
        256,
        (65535, 1, 2, 3, 4, 5, 1000, 0, 12, 700, 100, 0, 3, 1, 0x35, 1, 556, 0x84, 20000),
        "0321020501ffff01020202030204020503e80301020c04bc026401010e030135012c0284204e2ab8989100",
    ),
    ("pong", 3, 10000, (0x0001, 0xFFFE), "06220310270107feff7ac2543a00"),
    ("setting", 7, 0x1234, (1, 2, 43981), "0d140734120102cdabf6e8ace300"),
    ("telemetry", 7, 0x1234, (10,), "0a150734120a38c5e43400"),
    ("setting_reply", 7, 0x1234, (2, 13, 300, 19), "0e23073412020d2c0113fb7cdaab00"),
    (
        "zone",
        7,
        0x1234,
        (2, bytes(range(47)) + b"\xff"),
        (
            "062407341202340102030405060708090a0b0c0d0e0f101112131415161718191a1b"
            "1c1d1e1f202122232425262728292a2b2c2d2effdd189ccb00"
        ),
    ),
    ("limits", 8, 0x1234, (300, 150, 65535, 0, 254, 84), "08250834122c019603ffff07fe541332b74200"),
    (
        "trace",
        11,
        502,
        (65534, 255, bytes(range(49)) + b"\xff"),
        (
            "08260bf601feffff360102030405060708090a0b0c0d0e0f101112131415161718"
            "191a1b1c1d1e1f202122232425262728292a2b2c2d2e2f30ff6deb0a4400"
        ),
    ),
)
