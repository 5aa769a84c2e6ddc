"""A gamepad at the caretaker's page: its requests, and that it releases whenever in doubt."""

import itertools

import pytest

from gazechair.driving.control import HEARTBEAT_MS
from patience import wait_until
from webperson import CARETAKER, Driver

pytestmark = pytest.mark.browser

# Samples one after the other: {pads, ready}, or "ended": the joystick's press ended by itself.
RUN = """
async (samples) => {
  const { Gamepads } = await import("/static/gamepad.js");
  const events = [];
  let alive = false;
  const gamepads = new Gamepads({
    moveTo(place, fresh) {
      if (!fresh && !alive) return false;
      alive = true;
      events.push([fresh ? "press" : "lean", place.x, place.y]);
      return true;
    },
    letGo: () => { if (alive) events.push(["let go"]); alive = false; },
    stop: () => { events.push(["stop"]); alive = false; },
  });
  const steps = [];
  for (const sample of samples) {
    if (sample === "ended") alive = false;
    else gamepads.look(sample.pads, sample.ready);
    steps.push([events.splice(0), alive]);
  }
  return steps;
}
"""
SHAPED = "async ([x, y]) => (await import('/static/gamepad.js')).shaped(x, y)"


def pad(x=0.0, y=0.0, pressed=(), index=0, name="Wired pad", mapping="standard"):
    buttons = [{"pressed": n in pressed, "value": float(n in pressed)} for n in range(17)]
    axes = [x, y, 0.0, 0.0]
    return {
        "id": name,
        "index": index,
        "connected": True,
        "mapping": mapping,
        "axes": axes,
        "buttons": buttons,
    }


def at(*pads, ready=True):
    return {"pads": list(pads), "ready": ready}


MIDDLE, AHEAD, ASIDE = at(pad(0.05, -0.1)), at(pad(0, -1)), at(pad(-1, 0.1))


@pytest.fixture
def tell(plain_page):
    """The messages of each step."""
    return lambda *samples: [
        [entry[0] for entry in sent] for sent, _ in plain_page.evaluate(RUN, list(samples))
    ]


def test_the_middle_is_wide_and_the_push_grows_slowly_then_fully(plain_page):
    shaped = lambda x, y: plain_page.evaluate(SHAPED, [x, y])  # noqa: E731
    assert shaped(0.13, -0.15) is None
    assert shaped(0, -0.2) == pytest.approx({"x": 0, "y": 0})
    pushes = [-shaped(0, -share)["y"] for share in (0.3, 0.4, 0.6, 0.8, 1.0)]
    assert pushes == sorted(pushes)
    assert pushes[0] < 0.06
    assert pushes[2] == pytest.approx(0.4 * 0.5 + 0.6 * 0.5**3)
    assert pushes[-1] == pytest.approx(1)
    corner = shaped(1, 1)  # a square stick
    assert corner["x"] == corner["y"] == pytest.approx(0.7071, abs=1e-3)
    assert shaped(-0.7, 0)["x"] == -shaped(0.7, 0)["x"]


def test_a_stick_presses_leans_and_lets_go_in_its_middle(tell):
    sent = tell(MIDDLE, AHEAD, ASIDE, AHEAD, MIDDLE, MIDDLE, ASIDE)
    assert sent == [[], ["press"], ["lean"], ["lean"], ["let go"], [], ["press"]]


def test_a_stick_that_leans_when_it_is_connected_must_be_seen_in_its_middle(tell):
    assert tell(AHEAD, ASIDE, AHEAD) == [[], [], []]
    assert tell(AHEAD, MIDDLE, AHEAD) == [[], [], ["press"]]


def test_a_stick_that_leans_when_driving_becomes_possible_must_too(tell):
    waits = at(pad(0, -1), ready=False)
    rests = at(pad(), ready=False)
    assert tell(rests, waits, AHEAD, AHEAD) == [[], [], [], []]
    assert tell(MIDDLE, rests, AHEAD) == [[], [], []]
    assert tell(MIDDLE, AHEAD, waits, AHEAD) == [[], ["press"], ["let go"], []]


def test_unplugged_is_let_go_and_plugged_in_again_is_a_new_pad(tell):
    assert tell(MIDDLE, AHEAD, at(), AHEAD) == [[], ["press"], ["let go"], []]
    gone = {**pad(0, -1), "connected": False}
    assert tell(MIDDLE, AHEAD, at(gone)) == [[], ["press"], ["let go"]]
    other = at(pad(0, -1, name="Another pad"))
    assert tell(MIDDLE, AHEAD, other, other) == [[], ["press"], ["let go"], []]
    assert tell(MIDDLE, AHEAD, at(None, None)) == [[], ["press"], ["let go"]]


def test_a_press_that_ended_elsewhere_does_not_begin_again_by_itself(tell):
    sent = tell(MIDDLE, AHEAD, "ended", AHEAD, ASIDE, MIDDLE, AHEAD)
    assert sent == [[], ["press"], [], [], [], [], ["press"]]


def test_held_direction_buttons_push_half_and_the_stick_counts_before_them(plain_page, tell):
    ((_, _), (sent, _), (both, _)) = plain_page.evaluate(
        RUN, [MIDDLE, at(pad(pressed=(12, 14))), at(pad(1, 0, pressed=(12,)))]
    )
    assert sent == [["press", -0.5, -0.5]]
    assert both[0][1:] == [pytest.approx(1), 0]
    assert tell(MIDDLE, at(pad(pressed=(12,))), MIDDLE) == [[], ["press"], ["let go"]]
    assert tell(at(pad(pressed=(12,))), at(pad(pressed=(12,)))) == [[], []]


def test_the_four_buttons_stop_once_and_end_what_is_held(tell):
    stops = at(pad(0, -1, pressed=(1,)))
    assert tell(MIDDLE, AHEAD, stops, stops, AHEAD) == [[], ["press"], ["stop"], [], []]
    assert tell(at(pad(pressed=(0,)), ready=False)) == [["stop"]]


def test_a_layout_that_is_not_standard_has_a_stick_and_no_buttons(tell):
    odd = [pad(0, y, pressed=(0, 1, 12), mapping="") for y in (0, -1)]
    assert tell(at(odd[0]), at(odd[1])) == [[], ["press"]]
    assert tell(at({**pad(), "axes": []}), at({**pad(0, -1), "axes": [0]})) == [[], []]


def test_of_two_pads_the_first_that_presses_has_the_joystick(tell):
    def both(first, second):
        return at(pad(0, first), pad(0, second, index=1, name="second"))

    sent = tell(both(0, 0), both(-1, 0), both(-1, -1), both(0, -1), both(0, -1), both(0, 0))
    assert sent == [[], ["press"], ["lean"], ["let go"], [], []]  # the second leans since before


def test_no_sequence_of_samples_drives_without_a_centre_and_a_lean(plain_page):
    """Every sequence of four samples, against what must be true whatever came before."""
    samples = {
        "middle": MIDDLE,
        "ahead": AHEAD,
        "away": at(),
        "not ready": at(pad(0, -1), ready=False),
        "stop": at(pad(0, -1, pressed=(2,))),
        "ended": "ended",
    }
    names = list(itertools.product(samples, repeat=4))
    flat = [samples[name] for row in names for name in ("away", *row)]
    steps = iter(plain_page.evaluate(RUN, flat))
    for row in names:
        _, alive = next(steps)
        centred = False
        for name in row:
            sent, was, alive = *next(steps), alive
            sent, now = [entry[0] for entry in sent], was
            assert now == (name == "ahead" and (alive or centred)), (row, name)
            assert ("press" in sent) == (now and not alive), (row, name)
            assert ("stop" in sent) <= (name == "stop"), (row, name)
            if name != "ended":
                centred = name == "middle" or (centred and name == "ended")
            alive = now


# The page.

PADS = "pads => { window.pads = pads; navigator.getGamepads = () => window.pads; }"


class Hand(Driver):
    """A caretaker with a gamepad."""

    def hold(self, *pads, ms=100):
        self.page.evaluate(PADS, list(pads))
        self.advance(ms)

    def requests(self):
        """Requests since the last call, without repetitions."""
        sent = [(m["k"], m.get("linear"), m.get("turn")) for m in self.received("drive", "stop")]
        self.forget()
        return [request for n, request in enumerate(sent) if n == 0 or sent[n - 1] != request]


@pytest.fixture
def hand(page, host):
    """Has taken over, on a phone; the stick has been in its middle."""
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    host.state.update(you=True, owner="caretaker")
    person = Hand(page, host)
    person.open("caretaker")
    person.hold(pad(), ms=200)
    person.forget()
    return person


AHEAD_FULL, STOP = ("drive", 1000, 0), ("stop", None, None)


def test_the_stick_drives_as_the_pad_does_with_one_edge(hand, artefact):
    hand.page.locator("#pad").scroll_into_view_if_needed()
    hand.hold(pad(0, -1), ms=1000)
    drives = hand.received("drive")
    assert len(drives) - 1000 // HEARTBEAT_MS in (0, 1)
    assert {m["edge"] for m in drives} == {1}
    assert all({"token", "since"} <= set(m) for m in drives)
    artefact("caretaker-gamepad")
    assert hand.requests() == [AHEAD_FULL]
    hand.hold(pad(-1, 0))
    hand.hold(pad())
    assert hand.requests()[-2:] == [("drive", 0, 1000), STOP]
    hand.hold(pad(), ms=1000)
    assert hand.requests() == []


LOSSES = {
    "unplugged": lambda hand: hand.page.evaluate(
        "() => { window.pads = [null]; dispatchEvent(new Event('gamepaddisconnected')); }"
    ),
    "unplugged and back at once": lambda hand: hand.page.evaluate(
        "() => dispatchEvent(new Event('gamepaddisconnected'))"
    ),
    "blur": lambda hand: hand.page.evaluate("dispatchEvent(new Event('blur'))"),
    "pagehide": lambda hand: hand.page.evaluate("dispatchEvent(new Event('pagehide'))"),
    "stop": lambda hand: hand.page.locator("#stop").click(),
    "hidden": lambda hand: hand.page.evaluate(
        "() => { Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
        "document.dispatchEvent(new Event('visibilitychange')); }"
    ),
}


def test_whatever_ends_it_ends_it_at_once_until_the_stick_was_centred(hand):
    for how, lose in LOSSES.items():
        hand.hold(pad())
        hand.hold(pad(0, -1))
        assert hand.requests()[-1] == AHEAD_FULL, how
        lose(hand)  # and no time passes
        assert STOP in hand.requests(), how
        hand.hold(pad(0, -1), ms=500)
        assert AHEAD_FULL not in hand.requests(), how


def test_a_lost_link_and_a_lost_ownership_end_it(hand):
    hand.hold(pad(0, -1), ms=200)
    hand.forget()
    hand.run_for(700)
    assert hand.requests()[-1] == STOP
    hand.connect()
    hand.advance(500)
    assert hand.requests() == []
    hand.hold(pad())
    hand.hold(pad(0, -1))
    assert hand.requests()[-1] == AHEAD_FULL
    hand.state(you=False, owner="driver")
    hand.run_for(50)
    assert hand.requests()[-1] == STOP
    hand.advance(500)
    assert hand.requests() == []


def test_a_stick_that_leans_while_taking_over_does_not_drive(hand):
    hand.state(you=False, owner="driver")
    hand.hold(pad(0, -1), ms=500)
    hand.state(you=True, owner="caretaker")
    hand.advance(1000)
    assert hand.requests() == []


def test_finger_keys_and_stick_never_mix(hand):
    page = hand.page
    page.locator("#pad").scroll_into_view_if_needed()
    box = page.locator("#pad").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    hand.hold(pad(0, -1), ms=300)
    assert set(hand.requests()) == {("drive", 0, 0)}
    page.mouse.up()
    hand.advance(300)
    assert set(hand.requests()) == {STOP}  # the stick leans since before
    hand.hold(pad())
    hand.hold(pad(0, -1))
    page.keyboard.down("ArrowLeft")
    page.mouse.down()
    hand.advance(300)
    assert hand.requests() == [AHEAD_FULL]
    page.keyboard.up("ArrowLeft")
    page.mouse.up()
    hand.hold(pad())
    assert hand.requests() == [STOP]


def test_its_stop_button_stops_the_driver_too(hand):
    hand.state(you=False, owner="driver")
    hand.hold(pad(pressed=(1,)), ms=300)
    assert hand.received("stop") == [{"k": "stop"}]


def test_a_viewer_has_no_gamepad(page, host):
    host.welcome["role"] = "viewer"
    host.state.update(you=False, owner="driver")
    person = Hand(page, host)
    person.open("caretaker")
    person.hold(pad(), ms=200)
    person.hold(pad(0, -1), ms=500)
    assert person.received("drive") == []


def test_a_browser_without_gamepads_is_no_error(page, host):
    page.add_init_script("delete Navigator.prototype.getGamepads;")
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    person = Driver(page, host)
    person.open("caretaker")
    wait_until(lambda: person.data("ready") == "true", "the page")
    person.advance(200)
