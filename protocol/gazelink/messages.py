# The message table: every frame's type, direction and fields, and the hash that identifies it.
#
# Header of every frame: type u8, seq u8, stamp_ms u16. From the board, stamp_ms is its tick clock;
# to the board, it echoes the newest stamp received, so that the board can compute the age of a
# frame by its own clock. It repeats every 65.5 s; the CRC's seed includes the round it belongs to:
# see frame.Session.

import struct

from gazelink.const import const
from gazelink.settings_table import TABLE

HEADER_SIZE = const(4)
TYPE_AT = const(0)
SEQ_AT = const(1)
STAMP_AT = const(2)

UP = "up"  # host -> board
DOWN = "down"  # board -> host
BOTH = "both"

_SIZES = {"B": 1, "b": 1, "H": 2, "h": 2, "I": 4}


class Message:
    # One row of the table: fields as "name:format" with struct's letters (little-endian, unpadded).
    # Offsets count from the start of the frame, header included, so reading needs no arithmetic.

    # plain: its CRC is not seeded, as it is before a session begins; always so when frozen.

    def __init__(self, type_id, name, direction, fields, frozen=False, plain=False):
        self.type_id = type_id
        self.name = name
        self.direction = direction
        self.fields = fields
        self.frozen = frozen
        self.plain = frozen or plain
        self.names = []
        self.offsets = {}
        self.format = "<"
        at = HEADER_SIZE
        for field in fields.split():
            field_name, letter = field.split(":")
            self.names.append(field_name)
            self.offsets[field_name] = at
            self.format += letter
            at += _SIZES[letter[-1]] if letter[-1] in _SIZES else int(letter[:-1])
        self.size = at

    def pack(self, buf, values):
        # Write `values` (in table order) behind the header in buf. Not for the board's hot path.
        struct.pack_into(self.format, buf, HEADER_SIZE, *values)

    def unpack(self, buf):
        # {field: value} of a received frame in buf. Allocates: for the host and for tests.
        return dict(zip(self.names, struct.unpack_from(self.format, buf, HEADER_SIZE)))


# Frozen: layout and unseeded CRC of HELLO, FAULT and MAINTENANCE never change, so that two
# versions can always report that they differ, and an old board can be updated.
HELLO = Message(
    0x01,
    "hello",
    BOTH,
    # role, and the board's flags: codes.ROLE_*, codes.FLAG_*.
    # session: chosen by the host, echoed by the board, 0 = none yet. boot: drawn by the board at
    # reset.
    "role:B flags:B schema_hash:I session:H boot:H major:B minor:B patch:B name:16s",
    True,
)
FAULT = Message(0x02, "fault", DOWN, "reason:B detail:40s", True)
MAINTENANCE = Message(
    0x03,
    "maintenance",
    BOTH,
    # up: key must be MAINTENANCE_KEY; to a board that sends its last message, the reason of a FAULT
    # clears that fault; a running board ignores one with a reason. down: accepted 1, or 0 with the
    # reason.
    "key:I accepted:B reason:B",
    True,
)
MAINTENANCE_KEY = 0x11A7C0DE
NONCE = Message(
    0x04,
    "nonce",
    DOWN,
    # Follows each HELLO that answers a session: drawn by the board at random when the session
    # began, and in the seed of all its other frames, so that no recording fits. epoch: rounds of
    # the stamp since then, counted on by both ends.
    "session:H nonce:4s epoch:I",
    False,
    True,
)

COMMAND = Message(
    0x10,
    "command",
    UP,
    # edge changes with every new press; ttl_ms is what is left of the value's life at sending.
    # linear_ and turn_permille: of drive, and of a tuning pulse, which lasts pulse_ms at most.
    # cap_permille: no output beyond it, 1000 = no cap. In mode auto, the life counts from when its
    # planner decided.
    "verb:B mode:B edge:B owner:B ttl_ms:H linear_permille:h turn_permille:h cap_permille:H "
    "pulse_ms:H",
)
ORDER = Message(0x11, "order", UP, "action:B number:B owner:B")
CLEARANCE = Message(
    0x12,
    "clearance",
    UP,
    # Bits per direction (codes.DIR_*): blocked, whatever the distances are; unseen: the motion
    # enters an arc that this installation never sees. Distances until the footprint touches an
    # obstacle; the turns about the drive axle. CLEAR_FAR = nothing within range. arcs and
    # arc_views: of both axes at once, see arcs.py; views has a bit per quadrant, blind below,
    # unseen above.
    "blocked:B unseen:B source:B forward_mm:H backward_mm:H left_q4_deg:H right_q4_deg:H age_ms:H "
    "arc_views:B arcs:38s",
)
CLEAR_FAR = 65535
PING = Message(0x13, "ping", UP, "token_low:H token_high:H")
# index and value count for get and set only. Answered by SETTING_REPLY.
SETTING = Message(0x14, "setting", UP, "request:B index:B value:H")
# Period of STATE: 1..100 ms, 10 in each new session.
TELEMETRY = Message(0x15, "telemetry", UP, "state_period_ms:B")
# The caretaker's bypass button: number changes with every new press, ttl_ms as in COMMAND.
BYPASS = Message(0x16, "bypass", UP, "number:B ttl_ms:H")
# on 1: send TRACE, from a snapshot; again: a new snapshot. 0, and in each new session: none.
TRACE_REQUEST = Message(0x17, "trace_request", UP, "on:B")
# Supervision of the auto motion that press `edge` began: owner is who watches, age_ms how long ago
# that was proven. The board counts on from there.
SUPERVISION = Message(0x18, "supervision", UP, "edge:B owner:B age_ms:H")

STATE = Message(
    0x20,
    "state",
    DOWN,
    # status: state in the low nibble, motion in the high. decisions: 2 bits per direction.
    # heading_q4_deg: 1/16 degree, 0..5759, counter-clockwise positive. linear_ and turn_permille:
    # the outputs, of full deflection, forward and left positive; 0 at the stored neutral only.
    "status:B override:B arm_reason:B first_fault:B faults:I heading_q4_deg:H "
    "linear_permille:h turn_permille:h edge:B decisions:B",
)
STATS = Message(
    0x21,
    "stats",
    DOWN,
    # Counters wrap at 65536. us and ms maxima are since the previous stats frame. imu_status: bit 0
    # trusted, bits 2-5 the sensor's own calibration (gyro, accelerometer; 3 = calibrated).
    # speed_mm_s: upper bound of the forward or backward speed. profile: the selected one; bit 7:
    # the turn rate seen agrees with it. bypass_ms: what is left of a bypass, 0 = none.
    "rx_ok:H rx_corrupt:H rx_unknown:H rx_stale:H rx_bad:H tx_dropped:H tick_max_us:H tick_late:H "
    "service_max_ms:H heap_free_kb:H imu_samples:H imu_errors:H reset_cause:B relay:B imu_status:B "
    "owner:B speed_mm_s:H profile:B bypass_ms:H",
)
PONG = Message(0x22, "pong", DOWN, "token_low:H token_high:H")
# refused: a reason, 0 = done; value: what is in force now.
SETTING_REPLY = Message(0x23, "setting_reply", DOWN, "request:B index:B value:H refused:B")
# How the chair stops in one direction (codes.DIR_*), see zone.py: sent without a request, in each
# session, after each change of the settings, and periodically.
ZONE = Message(0x24, "zone", DOWN, "direction:B points:48s")

# What a host needs of the limits compiled into the board (gazeboard/core/limits.py): follows each
# NONCE; until then the host has no session. command_ttl_ms: a command or bypass lives no longer;
# auto_ttl_ms: nor does a command in mode auto. clearance_old_ms: obstacle data of that age counts
# as none. wiper_*: counts, at the window's ends and from neutral to full deflection.
LIMITS = Message(
    0x25,
    "limits",
    DOWN,
    "command_ttl_ms:H auto_ttl_ms:H clearance_old_ms:H wiper_min:B wiper_max:B wiper_span:B",
)
# What the board's ticks took, a stream of bytes (gazeboard/io/trace.py), when nothing else is to be
# sent. part: its number; begins: where in data a snapshot begins, 255 = nowhere.
TRACE = Message(0x26, "trace", DOWN, "part:H begins:B data:50s")

MESSAGES = (
    HELLO,
    FAULT,
    MAINTENANCE,
    NONCE,
    COMMAND,
    ORDER,
    CLEARANCE,
    PING,
    SETTING,
    TELEMETRY,
    BYPASS,
    TRACE_REQUEST,
    SUPERVISION,
    STATE,
    STATS,
    PONG,
    SETTING_REPLY,
    ZONE,
    LIMITS,
    TRACE,
)
BY_TYPE = {m.type_id: m for m in MESSAGES}


def schema_text(messages=MESSAGES, settings=TABLE):
    # Both tables as canonical text: any change that alters a meaning on the wire alters it.
    lines = [
        "%d %s %s %s %d" % (m.type_id, m.name, m.direction, m.fields, m.frozen + m.plain)
        for m in messages
    ]
    return "\n".join(lines + ["%s %d %d %d" % row for row in settings])
