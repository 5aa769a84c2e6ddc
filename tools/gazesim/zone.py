"""Computes how a board with given settings stops, for tools without a connected board."""

from __future__ import annotations

from gazeboard.core.obstacles import Obstacles
from gazeboard.io.settings import Settings
from gazechair.board.zone import BoardZone
from gazechair.sensing.clearance.zone import StopZone


def reported_zone(settings: Settings | None = None) -> BoardZone:
    """The zone as the board sends it; without settings, for the defaults."""
    return BoardZone(tuple(Obstacles(settings or Settings()).zone))


def zone_of(settings: Settings | None = None) -> StopZone:
    """The same zone, as the host uses it."""
    return StopZone(reported_zone(settings).points)
