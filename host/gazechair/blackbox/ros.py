"""The ROS 2 messages of the log: generated from the wire's message table, and standard ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from gazelink import codes, messages
from gazelink.messages import Message

PACKAGE = "gazechair_msgs/msg/"
# The handshake with its secret, and the line measurement: they cause no action.
UNRECORDED = (messages.NONCE, messages.PING, messages.PONG)

_TYPES = {"B": "uint8", "b": "int8", "H": "uint16", "h": "int16", "I": "uint32"}
_TEXTS = ("name", "detail")
_CODES: dict[str, Sequence[str]] = {
    "verb": codes.VERBS,
    "mode": codes.MODES,
    "owner": codes.OWNERS,
    "action": codes.ORDERS,
    "source": codes.SOURCES,
    "override": codes.REASONS,
    "arm_reason": codes.REASONS,
    "first_fault": codes.REASONS,
}
_NESTED = """\
{bar}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{bar}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{bar}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
{bar}
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
{bar}
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
{bar}
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
{bar}
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
{bar}
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
{bar}
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
{bar}
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
{bar}
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
{bar}
MSG: diagnostic_msgs/DiagnosticStatus
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
{bar}
MSG: diagnostic_msgs/KeyValue
string key
string value
""".format(bar="=" * 80)

TWIST = "geometry_msgs/msg/Twist"
ODOMETRY = "nav_msgs/msg/Odometry"
SCAN = "sensor_msgs/msg/LaserScan"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
PICTURE = "sensor_msgs/msg/CompressedImage"
LINE = "rcl_interfaces/msg/Log"
PLACES = "tf2_msgs/msg/TFMessage"
_STANDARD = {
    TWIST: "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    ODOMETRY: "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist",
    SCAN: "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
    "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
    "float32[] ranges\nfloat32[] intensities",
    DIAGNOSTICS: "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status",
    PICTURE: "std_msgs/Header header\nstring format\nuint8[] data",
    PLACES: "geometry_msgs/TransformStamped[] transforms",
    LINE: "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\n"
    "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\n"
    "string function\nuint32 line",
}


def wire_type(message: Message) -> str:
    """The ROS name of a message of the wire: "gazechair_msgs/msg/SettingReply"."""
    return PACKAGE + "".join(word.capitalize() for word in message.name.split("_"))


def _fields(message: Message) -> Iterator[tuple[str, str]]:
    for field in message.fields.split():
        name, letter = field.split(":")
        if letter in _TYPES:
            yield name, _TYPES[letter]
        else:
            yield name, "string" if name in _TEXTS else f"uint8[{letter[:-1]}]"


def _definition(message: Message) -> str:
    lines = ["builtin_interfaces/Time stamp", "uint8 seq", "uint16 board_ms"]
    for name, kind in _fields(message):
        if name in _CODES:
            texts = enumerate(_CODES[name])
            lines += [f"uint8 {name.upper()}_{text.upper()}={code}" for code, text in texts]
        lines.append(f"{kind} {name}")
    return "\n".join(lines)


# {ROS name: its definition, with what it contains, as an MCAP schema has it}
DEFINITIONS: dict[str, str] = {
    name: f"{text}\n{_NESTED}"
    for name, text in (
        *_STANDARD.items(),
        *(
            (wire_type(message), _definition(message))
            for message in messages.MESSAGES
            if message not in UNRECORDED
        ),
    )
}


def stamp(at_ns: int) -> dict[str, int]:
    """A time in ns as builtin_interfaces/Time."""
    return {"sec": at_ns // 10**9, "nanosec": at_ns % 10**9}


def from_frame(frame: bytes, at_ns: int) -> tuple[Message, dict[str, Any]] | None:
    """A frame without its CRC as (row of the message table, fields); None: not recorded."""
    message = messages.BY_TYPE[frame[messages.TYPE_AT]]
    if message in UNRECORDED:
        return None
    fields = message.unpack(frame)
    for name in _TEXTS:
        if name in fields:
            fields[name] = fields[name].split(b"\0")[0].decode("ascii", "replace")
    header = {
        "stamp": stamp(at_ns),
        "seq": frame[messages.SEQ_AT],
        "board_ms": int.from_bytes(frame[messages.STAMP_AT : messages.STAMP_AT + 2], "little"),
    }
    return message, header | fields
