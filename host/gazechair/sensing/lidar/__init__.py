"""The lidar: a child process that owns the device, and what it sees round the chair."""

from gazechair.sensing.lidar.service import LidarService

__all__ = ["LidarService"]
