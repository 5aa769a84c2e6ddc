"""Assist's process, and its service in the daemon: inputs, advice, and failures."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from gazechair.assist.child import Advisor
from gazechair.assist.message import Message, pack
from gazechair.assist.service import AssistService
from gazechair.base.health import Health
from gazechair.board.board_commands import STOP_COMMAND, Clearance, Command
from gazechair.board.zone import BoardZone
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazelink import codes
from gazesim.core_rig import Core
from patience import wait_until

LIDAR = LidarConfig(kind="s2", port="/nowhere", x_m=0.5, mask=((123.0, -123.0),))
ZONE = BoardZone(tuple(bytes(one) for one in Core().obstacles.zone))


def half_turn(at_s: float, second: bool) -> bytes:
    """Half a turn of a lidar in the middle of a room 6 m square."""
    angles = (-(np.arange(400) + 0.5) * 0.45 - (180.0 if second else 0.0) + 180.0) % 360.0 - 180.0
    c, s = np.abs(np.cos(np.radians(angles))), np.abs(np.sin(np.radians(angles)))
    return inbox.pack_scan(HalfTurn(0, angles, 3.0 / np.maximum(c, s), at_s - 0.05, at_s))


def vooruit(edge: int) -> Command:
    till_s = time.monotonic() + 0.3
    return Command(codes.FORWARD, codes.CONTINUOUS, edge, codes.DRIVER, till_s)


class Chair:
    """A standing chair with assist's service."""

    def __init__(self) -> None:
        self.on = True
        self.health = Health("assist")
        self.service = AssistService(
            (LIDAR,), FootprintConfig(), lambda: self.health, lambda: self.on
        )
        self.service.zone(ZONE)

    def feed(self) -> bool:
        """Run 0.1 s; True if assist knows its surroundings."""
        for second in (False, True):
            now_s = time.monotonic()
            inbox.send(self.service.inbox_fd, inbox.pack_motion(Motion(now_s, 90.0, 0, 0)))
            inbox.send(self.service.inbox_fd, half_turn(now_s, second))
            self.service.clearance(Clearance(0, codes.SIMULATED, now_s))
            time.sleep(0.05)
        self.service.steer(STOP_COMMAND, time.monotonic())
        return self.service.shown(time.monotonic()) == [True, False, False]


@pytest.fixture
def chair() -> Iterator[Chair]:
    made = Chair()
    yield made
    made.service.stop()


def test_its_process_starts_when_wanted_advises_and_a_killed_one_changes_nothing(
    chair: Chair,
) -> None:
    service = chair.service
    chair.on = False
    service.steer(vooruit(1), time.monotonic())
    assert service.pid is None
    assert service.shown(time.monotonic()) is None
    chair.on = True
    wait_until(chair.feed, "it knows its surroundings")
    assert chair.health.now().state == "ok"

    wait_until(lambda: is_active(chair, 2), "its advice")
    pid = service.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: service.pid != pid, "it is started again")
    sent = service.steer(vooruit(2), time.monotonic())
    assert (sent.verb, sent.linear_permille, sent.turn_permille) == (codes.DRIVE, 1000, 0)
    forward = vooruit(3)
    wait_until(lambda: not service._steering.works(time.monotonic()), "it is known to be blind")
    assert service.steer(forward, time.monotonic()) is forward


def is_active(chair: Chair, edge: int) -> bool:
    """Hold Vooruit for 0.1 s; True if advice has arrived."""
    for second in (False, True):
        now_s = time.monotonic()
        inbox.send(chair.service.inbox_fd, inbox.pack_motion(Motion(now_s, 90.0, 0, 0)))
        inbox.send(chair.service.inbox_fd, half_turn(now_s, second))
        chair.service.clearance(Clearance(0, codes.SIMULATED, now_s))
        chair.service.steer(vooruit(edge), now_s)
        time.sleep(0.05)
    advised = chair.service._steering.advised
    return advised is not None and advised.press == edge


def advisor(**message: object) -> Advisor:
    """An advisor that knows its surroundings at 10.0 s."""
    argument = {"lidars": [vars(LIDAR)], "footprint": vars(FootprintConfig())}
    made = Advisor(json.loads(json.dumps(argument)))
    made.take_message(pack(Message()))
    clearance = Clearance(0, codes.SIMULATED, 10.0)
    made.take_message(
        pack(Message(**{"on": True, "zone": ZONE, "clearance": clearance, **message}))
    )  # type: ignore[arg-type]
    for at_s, second in ((9.9, False), (9.95, True), (10.0, False)):
        made.take(inbox.pack_motion(Motion(at_s, 90.0, 0, 0)), at_s)
        made.take(half_turn(at_s, second), at_s)
    return made


def test_it_advises_the_held_press_and_knows_when_nothing_is_held() -> None:
    assert advisor().report(10.0) == [True, 0, 0, 0, False, False, 10.0]
    assert advisor(press=9).report(10.0) == [True, 9, 1000, 0, False, False, 10.0]
    assert advisor(turns=1).report(10.0) == [True, 0, 0, 0, False, False, 10.0]


def test_it_looks_at_nothing_while_nobody_wants_it() -> None:
    assert advisor(on=False, press=9).report(10.0) == [False, 0, 0, 0, False, False, 10.0]


def test_a_lidar_lost_or_blind_or_a_message_without_clearance_is_no_advice() -> None:
    one = advisor(press=9)
    assert one.report(10.3)[:2] == [False, 0]  # no newer data has arrived
    blind = Clearance(1 << codes.DIR_FORWARD, codes.SIMULATED, 10.0)
    assert advisor(press=9, clearance=blind).report(10.0)[:2] == [False, 0]
    assert advisor(press=9, clearance=None).report(10.0)[:2] == [False, 0]


def moved(one: Advisor, headings_deg: list[float | None], at_s: float) -> None:
    """Every 0.05 s from then on a heading, and half a turn of the lidar."""
    for k, heading_deg in enumerate(headings_deg):
        now_s = at_s + 0.05 * k
        one.take(inbox.pack_motion(Motion(now_s, heading_deg, 1000, 0)), now_s)
        one.take(half_turn(now_s, bool(k % 2)), now_s)


def pressed(one: Advisor, press: int, at_s: float) -> None:
    clearance = Clearance(0, codes.SIMULATED, at_s, forward_mm=700)
    one.take_message(pack(Message(True, press, 0, ZONE, clearance)))


BEFORE = [359.0, 359.5, 0.5, 1.0]
AFTER = [1.0] * 4


def test_after_a_heading_was_lost_the_press_turns_no_more_and_the_next_one_does_not_turn_back() -> (
    None
):
    one = advisor()
    moved(one, BEFORE[:3], 10.0)
    pressed(one, 9, 10.1)
    assert one.report(10.1)[:3] == [True, 9, 1000]
    moved(one, [1.0, None, *AFTER], 10.15)
    # The board ends this press at the first turn; straight on it goes on.
    assert one.report(10.4) == [True, 0, 0, 0, False, False, 10.4]
    pressed(one, 10, 10.4)
    assert one.report(10.4)[1:4] == [10, 1000, 0]


def test_a_press_that_began_without_a_heading_turns_no_more_either() -> None:
    one = advisor()
    moved(one, [None], 10.05)
    pressed(one, 9, 10.06)
    moved(one, AFTER, 10.1)
    assert one.report(10.25) == [True, 0, 0, 0, False, False, 10.25]


@pytest.mark.parametrize("between", [{"press": 10}, {"turns": 1}])
def test_the_number_of_a_press_that_had_lost_its_heading_serves_again(
    between: dict[str, int],
) -> None:
    one = advisor(press=9)
    moved(one, [None, *AFTER], 10.05)
    pressed(one, 0, 10.25)  # not renewed for a moment: it may be the same press still
    pressed(one, 9, 10.25)
    assert one.report(10.25)[:2] == [True, 0]
    clearance = Clearance(0, codes.SIMULATED, 10.25, forward_mm=700)
    one.take_message(pack(Message(on=True, zone=ZONE, clearance=clearance, **between)))  # type: ignore[arg-type]
    pressed(one, 0, 10.25)
    pressed(one, 9, 10.25)  # 255 presses later
    assert one.report(10.25)[1] == 9


def test_a_new_process_steers_no_press_that_began_before_it() -> None:
    # It does not know where that press pointed, and how far the chair has turned since.
    argument = {"lidars": [vars(LIDAR)], "footprint": vars(FootprintConfig())}
    one = Advisor(json.loads(json.dumps(argument)))
    pressed(one, 9, 10.0)
    moved(one, AFTER, 10.0)
    assert one.report(10.15) == [True, 0, 0, 0, False, False, 10.15]
    pressed(one, 10, 10.15)
    assert one.report(10.15)[:2] == [True, 10]


def test_a_lost_heading_counts_however_late_it_is_read() -> None:
    one = advisor(press=9)
    one.take(inbox.pack_motion(Motion(9.0, None, 0, 0)), 10.0)
    moved(one, AFTER, 10.05)
    assert one.report(10.2)[:2] == [True, 0]


def test_foreign_messages_and_datagrams_change_nothing() -> None:
    one = advisor(press=9)
    for line in (b"", b"\xff" * 4000, b"[]", b'[true, 4, false, ["00"]]', b'{"on": false}'):
        one.take_message(line)
    for datagram in (b"", b"S", b"\xff" * 60000, inbox.pack_motion(Motion(5.0, 0.0, 0, 0))):
        one.take(datagram, 10.0)
    assert one.report(10.0) == [True, 9, 1000, 0, False, False, 10.0]


NONSENSE = [b"", b"\xff", b"null", b"[]", b"[1,2,3]", b'[true,"a",0,0,true,false,1.0]']


@pytest.mark.parametrize("record", [*NONSENSE, b"[true,1,NaN,0,true,false,1]"])
def test_a_record_of_nonsense_is_an_error_of_the_child(chair: Chair, record: bytes) -> None:
    before = chair.service._steering.advised
    with pytest.raises((ValueError, TypeError)):
        chair.service._on_data(record)
    assert chair.service._steering.advised is before


def test_that_it_waits_for_what_may_be_a_person_reaches_the_page(chair: Chair) -> None:
    stopped = Clearance(0, codes.SIMULATED, 10.0, forward_mm=0)
    results = advisor(press=9, clearance=stopped).report(10.0)
    assert results == [True, 9, 0, 0, False, True, 10.0]
    now_s = time.monotonic()
    chair.service._on_data(json.dumps([*results[:-1], now_s]).encode())
    chair.service.steer(vooruit(9), now_s)
    assert chair.service.shown(now_s) == [True, False, True]
