"""What odometry's doubts are judged by: the board's outputs, and the motion that was measured."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.base.arrays import FloatArray

MOVES_M_S, MOVES_DEG_S = 0.06, 6.0
"""Slower, it may as well stand."""
DIFFERS_DEG = 0.6
"""From this difference on the lidars contradict the heading sensor; see Seen.heading_off_deg."""


@dataclass(frozen=True)
class Outputs:
    """What the board has put out in the seconds that are kept; left and forward are positive."""

    drive: int
    """Permille: the least in one direction over the time that the chair takes to start."""
    turn: int
    """The same for the turn output."""
    most_turn: int
    """The largest turn output of the time that is kept, without sign."""
    idle_s: float
    """Time since the last output; without one, since the oldest that is kept."""
    forward_s: float
    """Time since the last output that could have moved it forward; inf: none is kept."""
    backward_s: float
    left_s: float
    right_s: float


@dataclass(frozen=True)
class Seen:
    """What doubts are judged by, at one time."""

    time_s: float
    heading_known: bool
    points: int
    information: FloatArray
    """(2, 2), of the position by this piece alone, 1/m^2."""
    matched: float
    speed_m_s: float
    speed_sigma_m_s: float
    sideways_m_s: float
    yaw_rate_deg_s: float
    x_m: float
    y_m: float
    sensor_deg: float
    """Heading by the sensor alone, full turns counted."""
    got_on_m_s: float
    """Mean speed of the last moments, by positions alone."""
    ahead_m_s: float
    """Its part along the chair, negative: backward."""
    outputs: Outputs | None
    """None: not known."""
    full_m_s: float
    """The slowest speed of a full command, as learned for this chair; 0 or less: not known."""
    heading_off_deg: float
    """Recent difference between the turn seen by the lidars and that of the heading sensor."""
    late: bool
    """This piece is older than the board's reports by more than the limit."""
    silent: bool
    """Another lidar has sent nothing usable for longer than that before this piece."""
    turned: bool
    """See mounting."""
