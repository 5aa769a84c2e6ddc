"""The lidar: a child process owns the device; what it sees round the chair."""

from gazechair.sensing.lidar.service import LidarService

__all__ = ["LidarService"]
