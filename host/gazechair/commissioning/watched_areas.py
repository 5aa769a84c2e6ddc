"""Lets turns enter areas that no lidar sees, while a person watches them."""

from __future__ import annotations

from dataclasses import replace

from gazechair.board.board_commands import Clearance
from gazelink import codes

PERMITTED_S = 0.6  # until the board permits more speed: 0.3 s of a better view, and some scans
_TURNS = 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT


def with_eyes(clearance: Clearance) -> Clearance:
    """`clearance` when a person watches the areas that no lidar of this chair sees: a turn then
    enters nothing unseen. Seen and blocking areas stay."""
    return replace(clearance, unseen=clearance.unseen & ~_TURNS)
