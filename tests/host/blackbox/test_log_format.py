"""The log's files open without our code: rosbags finds every message, with its values."""

from __future__ import annotations

import io
import math
import re
from collections import Counter
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap_ros2.writer import Writer
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import gazesetup
from gazechair.blackbox import ros, topics
from gazechair.blackbox.reader import LogFile
from gazechair.sensing.lidar.scan import Pose
from gazechair.sensing.odometry.estimate import Estimate
from gazelink import codes, messages
from gazereplay import board_trace, trace

BEAMS_MM = range(1000, 1719)


def read(path: Path) -> dict[str, list[Any]]:
    """{topic: messages} by rosbags, which takes the types from the file."""
    found: dict[str, list[Any]] = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(message)
    return found


@pytest.fixture(scope="module")
def found(recorded: Path) -> dict[str, list[Any]]:
    return read(recorded)


def test_rosbags_reads_what_our_reader_reads(recorded: Path, found: dict[str, list[Any]]) -> None:
    ours = Counter(line.topic for line in LogFile(recorded).lines())
    theirs = {topic: len(lines) for topic, lines in found.items()}
    assert theirs == ours
    kinds = {"/scan/front", "/health", "/latency", "/picture", "/rosout", "/board/output"}
    frames = {"/host/command", "/host/clearance", "/host/order", "/board/state", "/board/stats"}
    assert kinds | frames <= theirs.keys()
    assert theirs["/board/state"] > 400


def test_standard_messages_say_what_happened(found: dict[str, list[Any]]) -> None:
    (scan,) = found["/scan/front"]
    assert scan.ranges[0] == math.inf
    assert [round(range_m * 1000) for range_m in scan.ranges[1:]] == list(BEAMS_MM)
    assert math.isclose(scan.angle_min + 719 * scan.angle_increment, scan.angle_max, abs_tol=1e-5)
    (health,) = found["/health"]
    parts = [(status.name, status.level, status.message) for status in health.status]
    assert parts == [("board", 0, "ok"), ("lidar", 2, "lidar_lost")]
    assert bytes(found["/picture"][0].data) == b"\xff\xd8small\xff\xd9"
    (line,) = found["/rosout"]
    assert (line.level, line.msg) == (30, "session ended: unplugged ?")
    outputs = [output.linear.x for output in found["/board/output"]]
    assert outputs == [state.linear_permille / 1000 for state in found["/board/state"]]
    assert max(outputs) > 0.1


def test_a_lidar_is_where_it_is(found: dict[str, list[Any]]) -> None:
    """By the same words as the evaluation: Pose."""
    (message,) = found["/tf_static"]
    front, rear = message.transforms
    assert (front.header.frame_id, front.child_frame_id) == ("chair", "front")
    assert rear.child_frame_id == "rear_left"
    for row, pose in ((front, Pose(0.5, -0.1)), (rear, Pose(-0.4, 0.3, 90.0, True))):
        moved = row.transform
        assert (moved.translation.x, moved.translation.y) == (pose.x_m, pose.y_m)
        for angle_deg in (0.0, 30.0, -120.0):
            q = moved.rotation
            x, y = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
            # The rotation matrix of q, applied to (x, y, 0).
            turned_x = (1 - 2 * (q.y**2 + q.z**2)) * x + 2 * (q.x * q.y - q.z * q.w) * y
            turned_y = 2 * (q.x * q.y + q.z * q.w) * x + (1 - 2 * (q.x**2 + q.z**2)) * y
            (expected_deg,) = pose.directions_deg(np.array([angle_deg]))
            assert math.isclose(turned_x, math.cos(math.radians(expected_deg)), abs_tol=1e-9)
            assert math.isclose(turned_y, math.sin(math.radians(expected_deg)), abs_tol=1e-9)


def test_frames_say_what_happened(found: dict[str, list[Any]]) -> None:
    verbs = {command.verb for command in found["/host/command"]}
    assert verbs == {codes.STOP, codes.FORWARD, codes.LEFT}
    states = found["/board/state"]
    assert {state.status & 15 for state in states} >= {codes.DISARMED, codes.ARMED}
    times_s = [state.stamp.sec + state.stamp.nanosec / 1e9 for state in states]
    assert times_s == sorted(times_s)
    # 100 a second, each with the board's own clock.
    assert {(b.board_ms - a.board_ms) & 0xFFFF for a, b in pairwise(states)} == {10}
    assert found["/board/hello"][0].name
    arcs = [bytes(clearance.arcs) for clearance in found["/host/clearance"]]
    assert {len(one) for one in arcs} == {38}


def test_a_reader_without_our_tables_finds_the_names_of_the_codes() -> None:
    assert f"uint8 VERB_FORWARD={codes.FORWARD}" in ros.DEFINITIONS["gazechair_msgs/msg/Command"]


def test_the_secret_of_a_session_is_not_recorded(found: dict[str, list[Any]]) -> None:
    assert messages.NONCE in ros.UNRECORDED
    assert not [topic for topic in found if "nonce" in topic]
    assert not [*topics.messages_of("down", 0, bytes([messages.NONCE.type_id]) + bytes(20))]


@pytest.mark.parametrize("name", [message.name for message in messages.MESSAGES])
def test_every_message_of_the_wire_goes_into_a_file_and_out(name: str, tmp_path: Path) -> None:
    message = next(message for message in messages.MESSAGES if message.name == name)
    frame = bytes([message.type_id, 7, 0x34, 0x12]) + bytes(
        97 + at % 26 for at in range(message.size - messages.HEADER_SIZE)
    )
    if message in ros.UNRECORDED:
        assert ros.from_frame(frame, 0) is None
        return
    ((topic, kind, fields), *_) = topics.messages_of("up", 5 * 10**9 + 6, frame)
    out = io.BytesIO()
    writer = Writer(out)
    schema = writer.register_msgdef(kind, ros.DEFINITIONS[kind])
    writer.write_message(topic, schema, fields)
    writer.finish()
    file = tmp_path / "one.mcap"
    file.write_bytes(out.getvalue())
    ((read_back,),) = read(file).values()
    expected = message.unpack(frame)
    assert (read_back.stamp.sec, read_back.stamp.nanosec) == (5, 6)
    assert (read_back.seq, read_back.board_ms) == (7, 0x1234)
    for field, value in expected.items():
        got = getattr(read_back, field)
        if isinstance(got, str):
            got = got.encode()
        assert (bytes(got) if isinstance(value, bytes) else got) == value, field


def test_odometry_is_a_message_of_ros_with_its_uncertainty_and_age(tmp_path: Path) -> None:
    estimate = Estimate(3.5, 1.0, 2.0, 90.0, 0.4, 0.01, 5.0, 0.2, 0.1, 1.0, 0.05, 0.9, ("x",), 2)
    out = io.BytesIO()
    writer = Writer(out)
    for topic, kind, fields in topics.messages_of(
        "motion", 10**9, {**asdict(estimate), "age_s": 0.07}
    ):
        schema = writer.register_msgdef(kind, ros.DEFINITIONS[kind])
        writer.write_message(topic, schema, fields)
    writer.finish()
    file = tmp_path / "one.mcap"
    file.write_bytes(out.getvalue())
    found = read(file)
    (messages_of,), (doubted,) = found["/odometry"], found["/odometry/doubts"]
    assert (messages_of.header.frame_id, messages_of.child_frame_id) == ("odom_2", "chair")
    assert (messages_of.pose.pose.position.x, messages_of.pose.pose.position.y) == (1.0, 2.0)
    assert messages_of.pose.pose.orientation.z == pytest.approx(math.sqrt(0.5))
    # It looks along y: what it is unsure of along its way is y.
    covariance = messages_of.pose.covariance
    assert [covariance[0], covariance[7]] == pytest.approx([0.1**2, 0.2**2])
    assert messages_of.twist.twist.linear.x == 0.4
    assert messages_of.twist.twist.angular.z == pytest.approx(math.radians(5.0))
    assert messages_of.twist.covariance[0] == pytest.approx(0.05**2)
    (status,) = doubted.status
    assert (status.level, status.message) == (1, "x")
    assert {row.key: row.value for row in status.values}["age_ms"] == "70.0"


def test_a_topic_is_named_as_ros_wants_it() -> None:
    ((topic, _, _),) = topics.messages_of("scan", 0, ("left-rear", bytes(8)))
    assert topic == "/scan/left_rear"


def test_definitions_are_what_ros_takes() -> None:
    store = get_typestore(Stores.EMPTY)
    for name, text in ros.DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
        assert name in store.types


def test_the_document_names_every_topic() -> None:
    named = set(re.findall(r"`(/[\w/]+)", (gazesetup.ROOT / "docs" / "log.md").read_text()))
    for message in messages.MESSAGES:
        if message not in ros.UNRECORDED:
            way = "host" if message.direction == messages.UP else "board"
            assert f"/{way}/{message.name}" in named
    code = Path(topics.__file__).read_text()
    assert set(re.findall(r'"(/\w+/)\{', code)) == {"/host/", "/board/", "/scan/"}
    plain = set(re.findall(r'"(/\w+(?:/\w+)*)"', code))
    assert {"/tf", "/tf_static", "/odometry/doubts", "/board/output"} < plain
    assert ({"/scan/NAME"} | plain | {*trace.DEFINITIONS, *board_trace.TOPICS}) - named == set()
