"""Lidars: from the bytes of a device to what surrounds the chair, in a child process."""

from gazechair.sensing.lidar.service import LidarService

__all__ = ["LidarService"]
