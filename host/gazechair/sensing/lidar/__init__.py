"""The lidar: a child process that owns the device, and the sectors that become obstacle flags."""

from gazechair.sensing.lidar.service import LidarService

__all__ = ["LidarService"]
