"""Learns where the chair itself blocks a configured lidar's view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.lidar.mask import Learned, learn
from gazechair.sensing.lidar.scan import Pose, Scan


def learned_mask(lidar: LidarConfig, scans: Sequence[Scan], footprint: FootprintConfig) -> Learned:
    """The mask of `lidar` from its scans. Raises MaskError."""
    pose = Pose(lidar.x_m, lidar.y_m, lidar.heading_deg, lidar.upside_down)
    return learn(scans, pose, np.array(footprint.corners_m, dtype=np.float64))
