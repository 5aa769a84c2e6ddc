"""The one switch of a driver who scans: a key, a button or a touch, in a real Chromium."""

import pytest

from fakehost import OFF
from webscanner import DIRECTIONS, opened

pytestmark = pytest.mark.browser


@pytest.mark.parametrize("how", ["the release has another name", "Cmd goes down"])
def test_a_switch_whose_release_cannot_be_recognised_drives_no_further(scanner, how):
    scanner.choose(DIRECTIONS, ["forward"])
    assert scanner.sent()[-1][0] == "cmd"
    if how == "Cmd goes down":
        scanner.page.keyboard.down("Meta")
    else:  # with Option or AltGr down
        scanner.page.evaluate(
            "dispatchEvent(new KeyboardEvent('keyup', {key: '\u00a0', code: 'Space'}))"
        )
        scanner.advance(75)
    assert scanner.sent()[-1] == ("stop", None, None)
    scanner.forget()
    scanner.advance(1000)
    assert scanner.sent() == []


def test_every_key_that_can_be_the_switch_does_nothing_else(page, host):
    scanner = opened(page, host)
    for name, key in {"enter": "Enter", "tab": "Tab", "f8": "F8", "space": " "}.items():
        scanner.state(**OFF)
        host.profiles.change({"save": {"id": "1", "scan_switch": name}}, True)
        scanner.state()
        scanner.takes_profiles()
        scanner.key = key
        scanner.state(state="armed", you=True, owner="driver")
        scanner.forget()
        scanner.choose(DIRECTIONS, ["forward"])
        scanner.up()
        scanner.advance(100)
        assert [kind for kind, *_ in scanner.sent()] == ["cmd", "stop"], name
        assert page.evaluate("document.activeElement === document.body"), name
        assert scanner.received("disarm") == [], name


def test_a_button_is_the_switch_and_two_fingers_are_one(page, host):
    scanner = opened(page, host, scan_switch="click")
    session = page.context.new_cdp_session(page)

    def touch(kind, *points):
        dots = [{"x": x, "y": 300 + 50 * x, "id": x} for x in points]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": dots})

    scanner.wait_for(*DIRECTIONS)
    touch("touchStart", 1)
    scanner.advance(100)
    touch("touchStart", 1, 2)
    scanner.advance(100)
    touch("touchEnd", 2)
    scanner.advance(100)
    touch("touchEnd")
    assert scanner.sent() == []
    scanner.wait_for("forward")
    touch("touchStart", 1)
    scanner.advance(300)
    assert scanner.sent() == [("cmd", "forward", 1)]
    touch("touchStart", 1, 2)  # a press while the chair moves
    assert scanner.sent() == [("stop", None, None)]
    scanner.advance(500)
    touch("touchEnd", 2)
    scanner.advance(500)
    assert scanner.sent() == []
    touch("touchEnd")
    scanner.look("stop")
    scanner.forget()
    scanner.page.mouse.down()  # on STOP itself
    assert scanner.sent() == [("stop", None, None)]


def test_a_second_mouse_button_hides_no_release(page, host):
    scanner = opened(page, host, scan_switch="click")
    page.mouse.move(*scanner.spot((0.5, 0.6)))
    scanner.wait_for(*DIRECTIONS)
    page.mouse.down()
    scanner.advance(100)
    page.mouse.up()
    scanner.wait_for("forward")
    page.mouse.down()
    scanner.advance(200)
    page.mouse.down(button="right")
    page.mouse.up(button="left")
    scanner.advance(100)
    assert scanner.sent()[-1] == ("stop", None, None)
