"""What comes of the bytes of a board: the events of its protocol."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.board.zone import BoardZone


@dataclass(frozen=True)
class SessionBegun:
    """The handshake is done: frames of this session count from now on."""

    board: BoardId


@dataclass(frozen=True)
class SessionEnded:
    """The session is over; a new handshake has begun."""

    detail: str


@dataclass(frozen=True)
class VersionDiffers:
    """A board answers, but with another message table."""

    detail: str


@dataclass(frozen=True)
class Pong:
    """A round trip ended."""

    round_trip_s: float


@dataclass(frozen=True)
class FaultText:
    """A FAULT frame: the board's own report."""

    reason: str
    detail: str


@dataclass(frozen=True)
class SettingReply:
    """The board's answer about a setting; numbers as in codes.SETTING_... and settings_table."""

    request: int
    index: int
    value: int
    """What is in force now."""
    refused: int
    """A reason code; 0 = done."""


Event = (
    SessionBegun
    | SessionEnded
    | VersionDiffers
    | Pong
    | FaultText
    | SettingReply
    | BoardState
    | BoardStats
    | BoardZone
)
