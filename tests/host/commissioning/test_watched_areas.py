"""The operator checks the area that no lidar of the chair sees."""

from __future__ import annotations

from gazechair.board.board_commands import Clearance
from gazechair.commissioning.watched_areas import with_eyes
from gazelink import codes


def test_a_person_sees_for_turns_alone_what_no_lidar_does_and_never_over_what_one_does() -> None:
    turns = 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
    for bits in range(16):
        seen = Clearance(bits, codes.REAL, 1.0, bits, 100, 200, 30, 40)
        with_person = with_eyes(seen)
        assert with_person.unseen == bits & ~turns
        assert with_person == Clearance(bits, codes.REAL, 1.0, bits & ~turns, 100, 200, 30, 40)
