"""The rendered picture, and how it is served."""

import io
import socket
import threading
import time
import urllib.error
import urllib.parse
import urllib.request

import numpy as np
import pytest
from PIL import Image

from gazesim import plans
from gazesim.camera import Camera
from gazesim.render import HEIGHT, WIDTH, Renderer
from gazesim.rooms import box

GENEROUS_S = 20.0


def picture(room, pose):
    data = Renderer().render(room, *pose)
    return np.frombuffer(data, dtype=np.uint8).reshape(HEIGHT, WIDTH, 4)[:, :, :3].astype(int)


def test_floor_is_below_wall_is_before_ceiling_is_above():
    image = picture(plans.room("wall"), (0.0, 0.0, 0.0))
    red, green, blue = image[HEIGHT - 20, WIDTH // 2]
    assert red > green > blue  # wood
    ceiling, wall = image[5, WIDTH // 2], image[200, WIDTH // 2]
    assert min(ceiling) > 180
    assert abs(int(ceiling[0]) - int(wall[0])) > 5


def test_a_nearer_wall_fills_more_of_the_picture():
    room = plans.room("wall")
    heights = []
    for x in (-1.0, 1.0, 2.5):
        image = picture(room, (x, 0.0, 0.0))
        wall = image[:, WIDTH // 2]
        heights.append(int((abs(wall[:, 0] - wall[:, 2]) < 40).sum()))
    assert heights == sorted(heights)


def test_what_stands_left_is_seen_left_and_hides_what_is_behind():
    room = plans.room("open")
    before = picture(room, (0.0, 0.0, 0.0))
    room.put("obstacle", box(2.0, 0.6, 0.4, 0.4, 0.0, 1.0, "sofa"))
    changed = (picture(room, (0.0, 0.0, 0.0)) != before).any(axis=2)
    columns = np.flatnonzero(changed.any(axis=0))
    assert columns.size
    assert columns.max() < WIDTH // 2
    room.put("obstacle", box(12.0, 0.6, 0.4, 0.4, 0.0, 1.0, "sofa"))  # behind the wall
    assert not (picture(room, (0.0, 0.0, 0.0)) != before).any()


@pytest.mark.parametrize("name", [*plans.names(), "home-3"])
def test_every_view_of_every_room_can_be_rendered(name):
    room = plans.room(name)
    for heading_deg in range(0, 360, 60):  # each view is 75 degrees wide
        assert picture(room, (*room.start[:2], float(heading_deg))).std() > 5


@pytest.fixture
def camera():
    room = plans.room("living")
    served = Camera(lambda: (room, room.start))
    served.start()
    yield served
    served.stop()
    names = [thread.name for thread in threading.enumerate()]
    assert not [name for name in names if name.startswith("camera")]


def read_part(stream):
    """Headers and body of the next part of a multipart stream."""
    while (line := stream.readline()).strip() != b"--frame":
        assert line, "the stream ended"
    headers = {}
    while line := stream.readline().strip():
        key, _, value = line.decode().partition(": ")
        headers[key] = value
    return headers, stream.read(int(headers["Content-Length"]))


def test_it_serves_fresh_jpegs_with_their_time(camera):
    began_s = time.monotonic()
    with urllib.request.urlopen(camera.url, timeout=GENEROUS_S) as stream:
        assert "multipart/x-mixed-replace" in stream.headers["Content-Type"]
        taken = []
        for _ in range(3):
            headers, jpeg = read_part(stream)
            assert Image.open(io.BytesIO(jpeg)).size == (WIDTH, HEIGHT)
            assert len(jpeg) < 60_000
            taken.append(float(headers["X-Timestamp"]))
    assert began_s <= taken[0] < taken[1] < taken[2] <= time.monotonic()


def test_a_slow_reader_misses_frames_and_gets_a_new_one(camera):
    slow = socket.socket()
    slow.settimeout(GENEROUS_S)
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
    slow.connect(("127.0.0.1", urllib.parse.urlsplit(camera.url).port))
    slow.sendall(b"GET / HTTP/1.0\r\n\r\n")
    with slow, slow.makefile("rb") as stream:
        read_part(stream)
        with urllib.request.urlopen(camera.url, timeout=GENEROUS_S) as other:
            for _ in range(20):
                latest = float(read_part(other)[0]["X-Timestamp"])
        behind = 0
        while float(read_part(stream)[0]["X-Timestamp"]) < latest:
            behind += 1
    assert behind < 12  # those in the sockets' buffers, not all twenty


def test_nothing_is_rendered_while_nobody_looks(camera):
    with urllib.request.urlopen(camera.url, timeout=GENEROUS_S) as stream:
        read_part(stream)
    end_s = time.monotonic() + GENEROUS_S
    while camera.readers and time.monotonic() < end_s:
        time.sleep(0.02)
    assert camera.readers == 0


def test_switched_off_it_refuses_and_then_serves_again(camera):
    camera.off = True
    with pytest.raises(urllib.error.HTTPError, match="503"):
        urllib.request.urlopen(camera.url, timeout=GENEROUS_S)
    camera.off = False
    with urllib.request.urlopen(camera.url, timeout=GENEROUS_S) as stream:
        read_part(stream)
