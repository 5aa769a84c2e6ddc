"""The daemon's messages arrive at assist's process unchanged; malformed ones are refused."""

import select

import pytest

from gazechair.assist.message import Message, pack, unpack
from gazechair.board.board_commands import Clearance
from gazechair.board.zone import BoardZone
from gazelink import arcs, codes, zone
from gazesim.core_rig import Core


def whole():
    points = tuple(bytes(one) for one in Core().obstacles.zone)
    assert all(len(one) == zone.SIZE for one in points)
    clearance = Clearance(
        3, codes.SIMULATED, 12.25, 1, 900, 800, 77, 88, 5, tuple(range(arcs.SIZE))
    )
    return Message(True, 255, -1, BoardZone(points), clearance)


def test_it_arrives_as_it_was_said_on_one_short_line():
    message = whole()
    line = pack(message)
    assert b"\n" not in line
    assert len(line) < select.PIPE_BUF - 1
    found, stopping = unpack(line)
    assert found.clearance is not None
    assert list(found.clearance.arcs) == list(range(arcs.SIZE))
    assert (found.zone, found.press, found.on, found.turns) == (message.zone, 255, True, -1)
    assert found.clearance.forward_mm == 900
    assert stopping.of(codes.DIR_FORWARD) is not None
    assert unpack(pack(Message()))[0] == Message()


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"\xff" * 300,
        b"null",
        b"{}",
        b"[true]",
        b'[true, "x", false, []]',
        b"[true, 1, false, [12]]",
        b'[true, 1, false, ["zz"]]',
        b'[true, 1, false, ["00"]]',
        b"[true, 1, false, [], [1, 2]]",
        b"[true, 1, false, [], 5]",
        pack(whole())[:-40],
    ],
)
def test_nonsense_is_refused(line):
    with pytest.raises(ValueError, match=r".*"):
        unpack(line)
