"""A chair that stands in a home with a map finds itself: odometry's and mapping's processes."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest

from gazechair.base.health import Health
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.feed import Feed
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazesim.home_drive import FRONT, LIDAR_HEIGHT_M
from maprig import START_S, made
from patience import wait_until

pytestmark = pytest.mark.e2e

HOME, MADE_S = 3, 20.0  # where it ends, most that is seen has been seen on the way


def test_the_processes_find_a_chair_that_stands_there(tmp_path: Path) -> None:
    """Odometry's and mapping's own, fed as in the daemon."""
    maker = made(tmp_path, HOME, "a", MADE_S)
    maker.go(1.0)
    config = LidarConfig(kind="s2", port="/nowhere", x_m=FRONT.x_m, mask=((123.0, -123.0),))
    odometry = OdometryService((config,), Health("odometry"), Obeys(Health("m"), lambda: None))
    mapping = MappingService((config,), maker.folder, Health("map"))
    odometry.subscribe(mapping.estimate)
    feed = Feed((odometry.inbox_fd, mapping.inbox_fd))
    newest = maker.told.newest["fix"]  # the worker that made the map knows it
    home, pose = maker.drive.home, maker.drive.truth(newest["time_s"] - START_S)
    turned = math.radians(pose.heading_deg)
    place = pose.x_m + FRONT.x_m * math.cos(turned), pose.y_m + FRONT.x_m * math.sin(turned)
    halves = []
    for half in range(2):  # of the mirror's turn, clockwise
        angles = -(np.arange(400) + 0.5) * 0.45 - half * 180.0
        angles = (angles + 180.0) % 360.0 - 180.0
        metres = home.cast(*place, np.radians(angles + pose.heading_deg), LIDAR_HEIGHT_M)
        halves.append((angles, metres))

    def found() -> Whereabouts | None:
        halves.reverse()
        now_s = time.monotonic()
        for fd in feed.fds:
            inbox.send(fd, inbox.pack_motion(Motion(now_s, 90.0, 0, 0)))
            inbox.send(fd, inbox.pack_scan(HalfTurn(0, *halves[0], now_s - 0.05, now_s)))
        time.sleep(0.05)
        return mapping.latest.get()

    odometry.start()
    mapping.start()
    try:
        where = wait_until(found, "that it knows where it is")
    finally:
        odometry.stop()
        mapping.stop()
    assert where.map == newest["map"] == "a"
    assert math.hypot(where.x_m - newest["x_m"], where.y_m - newest["y_m"]) < 0.05
    assert abs(where.heading_deg - newest["heading_deg"]) < 2.0
    assert time.monotonic() - where.time_s < 5.0
