"""Control: a page's messages reach the link at once, the board's states reach the page."""

from __future__ import annotations

import threading

import pytest

from controlrig import Rig
from gazechair.base import health as states
from gazechair.board.board_commands import Clearance
from gazechair.board.state import BoardId
from gazechair.config.settings import Config
from gazechair.driving.control import Control
from gazelink import codes
from gazelink.settings_table import profile_row
from gazesim.board_limits import LIMITS


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def armed(rig: Rig) -> Rig:
    rig.arm()
    return rig


def test_welcome_tells_how_the_page_is_to_behave(rig: Rig) -> None:
    assert rig.control.welcome(rig.page) == {
        "k": "welcome",
        "role": "driver",
        "simulated": False,
        "backward": False,
        "heartbeat_ms": 25,
        "token_ms": 500,
        "command_ttl_ms": 300,
        "modes": [],
        "plugins": [],
        "latched": [
            *("wiper", "tick_exception", "emergency", "watchdog_boots", "disobeys"),
            *("relay_unexpected", "storage"),
        ],
    }


def test_until_a_board_has_told_its_limits_nothing_is_assumed_of_them(rig: Rig) -> None:
    """A waiting page is notified of them; the limits of a board that has left stay valid."""
    link = rig.link
    fresh = Control(Config(), link, rig.parts, clock=lambda: rig.now_s)
    who, link.who = link.who, None
    fresh.update()
    page = fresh.connect("driver")
    fresh.clearance(Clearance(0, codes.REAL, rig.now_s))
    rig.now_s += 0.001
    assert fresh.welcome(page)["command_ttl_ms"] is None
    assert set(fresh.snapshot(page)["view"].values()) == {"blind"}
    version = fresh.wait_change(0.0, -1)
    link.who = who
    fresh.update()
    assert fresh.wait_change(0.0, version) != version
    assert fresh.welcome(page)["command_ttl_ms"] == 300
    assert set(fresh.snapshot(page)["view"].values()) == {"seen"}
    link.who = link.now = None
    fresh.update()
    assert fresh.welcome(page)["command_ttl_ms"] == 300


def test_the_configured_driver_is_the_first_profile(rig: Rig) -> None:
    mine = rig.control.profiles()["profiles"][0]
    assert (mine["mode"], mine["dwell_ms"], mine["leave_grace_ms"]) == ("continuous", 700, 200)
    assert rig.control.profiles()["fields"]["language"]["choices"][:2] == ["nl", "en"]


def test_a_changed_profile_is_news_for_the_pages(rig: Rig) -> None:
    version = rig.control.wait_change(0.0, -1)
    request = {"save": {"id": "1", "dwell_ms": 900}}
    answer = rig.control.change_profile(request, "driver")
    rig.control.update()
    assert rig.look()["profile"] == answer["revision"]
    assert rig.control.wait_change(0.0, version) != version
    assert rig.control.change_profile(request, "viewer")["reason"] == "not_allowed"
    assert rig.control.change_profile({"save": {"id": "9"}}, "driver")["reason"] == (
        "profile_unknown"
    )


def test_a_call_for_help_stays_until_somebody_comes(rig: Rig) -> None:
    assert rig.say(k="call", on=True) == []
    assert rig.look()["call"] is True
    rig.control.disconnect(rig.page)
    caretaker = rig.control.connect("caretaker")
    assert rig.control.snapshot(caretaker)["call"] is True
    assert rig.control.receive(caretaker, {"k": "call", "on": False}) == []
    assert rig.control.snapshot(caretaker)["call"] is False
    refusal = rig.control.receive(caretaker, {"k": "call", "on": True})
    assert refusal[0]["reason"] == "not_allowed"
    viewer = rig.control.connect("viewer")
    assert rig.control.receive(viewer, {"k": "call", "on": False})[0]["reason"] == "not_allowed"


def test_snapshot_has_every_key_of_the_protocol(rig: Rig) -> None:
    state = rig.look()
    token = state.pop("token")
    assert isinstance(token, int)
    assert state == {
        "k": "state",
        "state": "disarmed",
        "motion": "stopped",
        "override": "none",
        "arm_reason": "none",
        "decisions": dict.fromkeys(("forward", "backward", "left", "right"), "free"),
        "relay_checked": False,
        "tuned": None,
        "level": "ok",
        "message": "ok",
        "about": "",
        "board": "ok",
        "lidar": "ok",
        "camera": "ok",
        "owner": "nobody",
        "you": False,
        "auto": ["", ""],
        "edge": 0,
        "heading_deg": 90.0,
        "output_permille": [0, 12],
        "clearance": dict.fromkeys(("forward", "backward", "left", "right")),
        "view": dict.fromkeys(("forward", "backward", "left", "right"), "blind"),
        "cap_permille": 1000,
        "call": False,
        "coming": False,
        "heard": False,
        "alerts": 0,
        "stops": 0,
        "profile": rig.control.profiles()["revision"],
        "bypass_ms": 0,
        "simulated": False,
        "turned": None,
    }


def test_the_message_says_which_part_it_is_about_and_only_where_it_is_shown(rig: Rig) -> None:
    rig.parts.part("map").set("degraded", "lidar_turned")
    for names in ("rear", "rear / front"):
        rig.parts.part("odometry").set("degraded", "lidar_turned", "a line", names)
        version = rig.control.wait_change(0.0, -1)
        rig.control.update()
        assert rig.control.wait_change(0.0, version) != version
        caretaker = rig.control.snapshot(rig.control.connect("caretaker"))
        assert (caretaker["message"], caretaker["about"]) == ("lidar_turned", names)
        driver = rig.control.snapshot(rig.control.connect("driver"))
        assert (driver["message"], driver["about"]) == ("ok", "")
    rig.parts.part("board").set("lost", "board_lost", "unplugged")
    rig.control.update()
    assert rig.look()["about"] == ""


def test_without_a_board_the_snapshot_says_so(rig: Rig) -> None:
    rig.link.now = rig.link.who = None
    rig.parts.part("board").set("lost", "board_lost", "unplugged")
    rig.control.update()
    state = rig.look()
    assert (state["state"], state["arm_reason"]) == ("disarmed", "not_connected")
    assert set(state["decisions"].values()) == {"unknown"}
    assert (state["heading_deg"], state["output_permille"]) == (None, None)
    assert state["relay_checked"] is True  # nothing drives: one message is enough
    assert (state["board"], state["level"], state["message"]) == ("lost", "error", "board_lost")


def test_a_relay_found_to_be_unmonitored_is_news_for_the_pages(rig: Rig) -> None:
    rig.board(relay_checked=True)
    version = rig.control.wait_change(0.0, -1)
    assert rig.look()["relay_checked"] is True
    rig.board(relay_checked=False)
    assert rig.control.wait_change(0.0, version) != version
    assert rig.look()["relay_checked"] is False


def test_a_heading_with_a_fault_is_not_shown(rig: Rig) -> None:
    rig.board(faults=1 << codes.HEADING_FROZEN)
    assert rig.look()["heading_deg"] is None


def test_arming_reaches_the_board_and_the_owner_is_shown(rig: Rig) -> None:
    assert rig.say(k="arm", token=rig.look()["token"]) == []
    assert ("order", codes.ARM, codes.DRIVER) in rig.link.take()
    rig.board(state=codes.ARMED)
    state = rig.look()
    assert (state["state"], state["owner"], state["you"]) == ("armed", "driver", True)
    other = rig.control.connect("driver")
    assert rig.control.snapshot(other)["you"] is False


def test_a_press_reaches_the_link_within_the_call(armed: Rig) -> None:
    assert armed.forward() == []
    assert armed.link.take() == [("command", codes.FORWARD, codes.CONTINUOUS, codes.DRIVER)]


def test_a_stop_reaches_the_link_within_the_call(armed: Rig) -> None:
    armed.forward()
    armed.link.take()
    assert armed.say(k="stop") == []
    assert [sent[:2] for sent in armed.link.take()] == [("command", codes.STOP)]


def test_the_page_sees_its_own_edge_once_the_board_has_it(armed: Rig) -> None:
    armed.forward(edge=300)
    assert armed.look()["edge"] == 0
    command = armed.control._arbiter.command
    armed.board(state=codes.ARMED, edge=command.edge, motion=codes.MOVING_FORWARD)
    state = armed.look()
    assert (state["edge"], state["motion"]) == (300, "forward")


def test_a_bad_message_is_refused_and_nothing_is_said(armed: Rig) -> None:
    (refusal,) = armed.say(k="cmd", verb="up")
    assert (refusal["k"], refusal["what"], refusal["reason"]) == (
        "refused",
        "message",
        "bad_message",
    )
    assert armed.link.take() == []


def test_a_refused_command_says_why(rig: Rig) -> None:
    (refusal,) = rig.forward()
    assert (refusal["what"], refusal["reason"]) == ("cmd", "not_armed")


def test_a_closed_socket_stops_and_disarms_within_the_call(armed: Rig) -> None:
    armed.forward()
    armed.link.take()
    armed.control.disconnect(armed.page)
    sent = armed.link.take()
    assert ("order", codes.DISARM, codes.DRIVER) in sent
    assert any(row[:2] == ("command", codes.STOP) for row in sent)


def test_a_silent_page_is_stopped_and_shown(armed: Rig) -> None:
    armed.forward()
    armed.link.take()
    armed.now_s += 0.31
    armed.control.update()
    assert [row[:2] for row in armed.link.take()] == [("command", codes.STOP)]
    state = armed.look()
    assert (state["level"], state["message"]) == ("warning", "page_silent")


def test_versions_change_with_what_is_shown_but_not_with_the_output(rig: Rig) -> None:
    version = rig.control.wait_change(0, -1)
    rig.board(linear_permille=360, heading_deg=10.0, board_ms=77)
    assert rig.control.wait_change(0, version) == version
    rig.board(override=codes.OBSTACLE_LEFT)
    after = rig.control.wait_change(0, version)
    assert after != version
    assert rig.look()["override"] == "obstacle_left"


@pytest.mark.parametrize("tuned", [0, 1])
def test_a_profile_that_becomes_known_is_shown_at_once(rig: Rig, tuned: int) -> None:
    assert rig.look()["tuned"] is None
    version = rig.control.wait_change(0, -1)
    rig.board(settings={"profile": 2, profile_row(2, "tuned"): tuned})
    assert rig.look()["tuned"] is bool(tuned)
    assert rig.control.wait_change(0, version) != version


def test_a_waiting_server_is_woken(rig: Rig) -> None:
    version = rig.control.wait_change(0, -1)
    seen: list[int] = []
    waiter = threading.Thread(
        target=lambda: seen.append(rig.control.wait_change(30, version)), name="waiter"
    )
    waiter.start()
    rig.board(state=codes.ARMED)
    waiter.join(30)
    assert seen
    assert seen[0] != version


def test_scans_go_straight_to_the_link_and_mark_simulation(rig: Rig) -> None:
    scan = Clearance(5, codes.SIMULATED, 9.9)
    rig.control.clearance(scan)
    assert rig.link.take() == [("clearance", scan)]
    assert rig.look()["simulated"] is True


def test_a_simulated_board_is_marked(rig: Rig) -> None:
    rig.link.who = BoardId("fake", "0.2.0", True, 1, 2, LIMITS)
    assert rig.look()["simulated"] is True


def test_a_lidar_or_camera_silent_for_2_s_is_told(rig: Rig) -> None:
    rig.picture_age_s = 2.5
    rig.control.update()
    assert rig.look()["message"] == "camera_lost"
    rig.control.clearance(Clearance(0, codes.REAL, rig.now_s))
    rig.now_s += 2.1
    rig.control.update()
    assert (rig.look()["level"], rig.look()["message"]) == ("error", "lidar_lost")


def test_a_full_disk_is_told_to_the_caretaker_and_not_to_the_driver(rig: Rig) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.parts.part("log").set(states.DEGRADED, "log_full", "nothing is recorded")
    rig.control.update()
    assert rig.control.snapshot(caretaker)["message"] == "log_full"
    assert rig.look()["message"] == "ok"
    rig.parts.part("log").set(states.LOST, "log_missing", "pip install")
    rig.control.update()
    assert rig.control.snapshot(caretaker)["level"] == "ok"  # the doctor says so


def test_a_slow_or_hot_computer_is_told_to_both_and_errors_go_first(rig: Rig) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.parts.part("host").set(states.DEGRADED, "host_hot", "91 degrees Celsius")
    rig.control.update()
    assert rig.look()["message"] == "host_hot"
    assert rig.control.snapshot(caretaker)["message"] == "host_hot"
    rig.parts.part("lidar").set(states.LOST, "lidar_lost", "no such port")
    rig.control.update()
    assert rig.look()["message"] == "lidar_lost"


def test_stopping_stops_and_disarms(armed: Rig) -> None:
    armed.forward()
    armed.link.take()
    armed.control.stop()
    sent = armed.link.take()
    assert sent[0][:2] == ("command", codes.STOP)
    assert sent[1][:2] == ("order", codes.DISARM)


def test_time_acts_without_anyone_asking(armed: Rig) -> None:
    armed.forward()
    armed.control.start()
    armed.now_s += 1.0
    version = armed.control.wait_change(0, -1)
    try:
        while armed.look()["message"] != "page_silent":
            version = armed.control.wait_change(30, version)
    finally:
        armed.control.stop()


def test_health_is_told_by_part(rig: Rig) -> None:
    assert rig.control.health()["lidar"] == {
        "state": "ok",
        "reason": "ok",
        "detail": "",
        "for_s": 0.0,
    }


def test_a_press_of_a_mode_that_is_gone_ends_an_auto_motion_as_any_other_press(armed: Rig) -> None:
    armed.control.offer_mode("kitchen", {"auto": True})
    for edge, mode, auto in ((1, "kitchen", "kitchen"), (2, "bed", "")):
        sent = armed.say(k="mode", mode=mode, edge=edge, token=armed.look()["token"])
        assert [one["reason"] for one in sent] == ([] if auto else ["no_answer"])
        assert armed.control._arbiter.auto == auto
