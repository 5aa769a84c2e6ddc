"""Single-switch scanning: its state machine in Chromium, in simulated time, and enumerated."""

import pytest

pytestmark = pytest.mark.browser

TIMES = {"rows": True, "stepMs": 1000, "acceptMs": 50, "debounceMs": 40, "lockoutMs": 300}
DRIVE = ["forward", "left", "right"]
OTHERS = ["arm", "mode", "help"]
RUN = """
async (steps) => {
  const { Scan } = await import("/static/scan.js");
  const events = [];
  let now = 0;
  const on = {};
  for (const kind of ["show", "press", "release", "doubt", "stop", "used"]) {
    on[kind] = (...rest) => kind === "used" || events.push([now, kind, ...rest]);
  }
  const scan = new Scan(on);
  for (const [at, call, ...rest] of steps) {
    now = at;
    if (call === "down" || call === "up") scan[call](rest[0] ?? at, at);
    else scan[call](...rest, at);
  }
  return events;
}
"""
# Every sequence of events to a depth; the rules are those of docs/scanning.md, by what is seen.
ENUMERATE = """
async ({ times, begin, depth }) => {
  const { Scan } = await import("/static/scan.js");
  const { acceptMs, debounceMs, lockoutMs, stepMs } = times;
  const OFFERS = [[["forward", "left", "right"], ["arm", "help"]], [["arm"]]];
  const EVENTS = ["down", "up", "bounce", "tick", "wait", "step", "move", "rest", "offer", "lost"];
  let runs = 0, presses = 0, stops = 0;
  const wrong = [];

  function run(sequence) {
    let now = 1000, lit = ["stop"], before = null, litAt = now, moving = false, offer = 0;
    let closed = false, downAt = 0, openAt = -1e9; // the contact
    let press = null; // what the newest press may take: {at, names, left}
    let held = null, doubt = false, stopped = 0, freeAt = -1e9;
    const say = (rule) => wrong.length < 5 && wrong.push(`${rule}: ${sequence.join(" ")}`);
    const on = {
      show: (names) => { before = lit; lit = names; litAt = now; },
      used() {},
      stop: () => { stopped += 1; stops += 1; },
      doubt: (open) => { doubt = open; },
      release: () => { held = null; doubt = false; },
      press(name) {
        presses += 1;
        if (held) say("a choice while another is held");
        if (moving) say("a choice while the chair moves");
        if (!press || press.spent) return say("a choice without a press of its own");
        press.spent = true;
        if (press.names.length !== 1 || press.names[0] !== name) say("not what was lit");
        if (name === "stop") say("Stop is no choice, it stops");
        if (now - press.at < acceptMs) say("too short");
        if (!closed && now !== openAt) say("a choice without contact");
        held = name;
        doubt = false;
      },
    };
    const scan = new Scan(on);
    scan.configure(times, now);
    scan.offer(OFFERS[offer], now);
    const tick = () => {
      now += 25;
      scan.tick(now);
      if (!closed && now - openAt >= debounceMs && held) say("held without contact");
    };
    const begins = () => { if (lit.join() !== "stop") say("Stop is not the first"); };
    const down = () => {
      if (closed) return;
      const bounce = now - openAt < debounceMs;
      const was = stopped;
      if (!bounce) {
        const early = press?.over === undefined ? -1e9 : press.over + lockoutMs;
        const unseen = now < litAt + 50;
        const names = unseen && before ? before : lit;
        press = { at: now, names, spent: now < early };
        if (!moving && unseen && names === before && names.length > 1) press.names = names;
      }
      closed = true;
      scan.down(now, now);
      if (!bounce && moving) {
        press.spent = true;
        if (stopped === was) say("a press while the chair moves is no stop");
      }
      if (!bounce && stopped > was) press.spent = true;
      if (held && doubt) say("doubt while closed");
    };
    const up = () => {
      if (!closed) return;
      closed = false;
      openAt = now;
      scan.up(now, now);
      if (press) press.over = now;
      if (held && !doubt) say("proof without contact");
    };
    for (const event of sequence) {
      if (event === "down") down();
      else if (event === "up") up();
      else if (event === "bounce") { up(); now += 5; down(); }
      else if (event === "tick") tick();
      else if (event === "wait") { tick(); tick(); tick(); }
      else if (event === "step") { for (let t = 0; t < stepMs; t += 25) tick(); }
      else if (event === "move" || event === "rest") {
        const was = moving;
        moving = event === "move";
        // Held by this very press: it goes on.
        if (moving && !was && press && !held) press.spent = true;
        scan.setMoving(moving, now);
        if (was !== moving) begins();
      } else {
        const was = held;
        if (event === "offer") scan.offer(OFFERS[(offer ^= 1)], now);
        else scan.cancel(now);
        if (press) press.spent = true;
        const stays = event === "offer" && OFFERS[offer].flat().includes(was) ? was : null;
        if (held !== stays) say(`${event} leaves ${held} held, not ${stays}`);
        begins();
        // After a loss nobody knows of the contact: only a new closing is a press.
        if (event === "lost" && closed) { closed = false; openAt = -1e9; }
      }
    }
    runs += 1;
  }

  const sequence = [...begin];
  (function grow() {
    run(sequence);
    if (sequence.length === begin.length + depth) return;
    for (const event of EVENTS) {
      sequence.push(event);
      grow();
      sequence.pop();
    }
  })();
  return { runs, presses, stops, wrong };
}
"""


class Story:
    """Builds a sequence of events; choices are offered, Stop is lit."""

    def __init__(self, offered=(DRIVE, OTHERS), **times):
        self.now = 0
        self.steps = []
        self.call("configure", TIMES | times).call("offer", list(offered))

    def call(self, name, *rest):
        self.steps.append([self.now, name, *rest])
        return self

    def wait(self, ms):
        end = self.now + ms
        while self.now < end:
            self.now += 25
            self.call("tick")
        return self

    def down(self, *stamp):
        return self.call("down", *stamp)

    def up(self, *stamp):
        return self.call("up", *stamp)

    def press(self, ms=150):
        return self.down().wait(ms).up().wait(50)


@pytest.fixture
def tell(plain_page):
    """Runs a story and returns its outputs: [ms, kind, ...]."""
    return lambda story: plain_page.evaluate(RUN, story.steps)


def lit(events):
    return [entry[2] for entry in events if entry[1] == "show"]


def acts(events):
    return [entry[1:] for entry in events if entry[1] != "show"]


def into_row(story):
    """Choose the row of directions: forward is lit, and a press counts again."""
    return story.wait(1500).press().wait(350)


def test_stop_is_first_and_each_row_has_its_time(tell):
    events = tell(Story().wait(3000))
    assert events == [[1000, "show", DRIVE], [2000, "show", OTHERS], [3000, "show", ["stop"]]]


def test_few_choices_and_whoever_wants_so_are_lit_one_by_one(tell):
    few = tell(Story((["arm", "menu", "help"],)).wait(3000))
    assert lit(few) == [["arm"], ["menu"], ["help"]]
    wished = tell(Story(rows=False).wait(3000))
    assert lit(wished) == [["forward"], ["left"], ["right"]]


def test_time_alone_chooses_nothing_and_after_three_rounds_the_scan_rests_on_stop(tell):
    events = tell(Story().wait(60_000))
    assert acts(events) == []
    assert events[-1] == [9000, "show", ["stop"]]
    events = tell(Story().wait(60_000).press().wait(1000))
    assert acts(events) == [["stop"]]
    assert lit(events)[-1] == DRIVE


def test_a_row_is_chosen_then_its_target_and_then_stop_is_lit_again(tell):
    events = tell(into_row(Story()).wait(1000).press(400))
    assert acts(events) == [["press", "left"], ["doubt", True], ["release"]]
    assert lit(events) == [DRIVE, ["forward"], ["left"], ["stop"]]


def test_a_row_that_is_left_alone_gives_way_to_the_rows_after_two_rounds(tell):
    events = tell(into_row(Story()).wait(6500))
    assert lit(events)[-4:] == [["forward"], ["left"], ["right"], ["stop"]]
    assert acts(events) == []


def test_the_scan_waits_while_the_switch_is_pressed(tell):
    events = tell(Story().wait(1500).down().wait(10_000).up())
    assert lit(events) == [DRIVE, ["forward"]]


def test_a_choice_is_held_as_long_as_the_switch(tell):
    story = into_row(Story())
    began = story.now
    events = tell(story.down().wait(3000).up().wait(100))
    held = [entry for entry in events if entry[1] != "show"]
    assert held == [
        [began + 50, "press", "forward"],
        [began + 3000, "doubt", True],
        [began + 3050, "release"],
    ]


def test_a_short_touch_is_no_press(tell):
    story = Story(rows=False, acceptMs=300).wait(1200)
    for _ in range(5):
        story.down().wait(250).up().wait(100)
    assert acts(tell(story)) == []


def test_a_contact_that_bounces_is_one_press_and_stays_held(tell):
    story = into_row(Story())
    for _ in range(4):
        story.down()
        story.now += 3
        story.up()
        story.now += 2
    story.down().wait(200)
    for _ in range(3):
        story.up()
        story.now += 10
        story.down().wait(100)
    events = acts(tell(story.up().wait(100)))
    assert [entry[0] for entry in events if entry[0] != "doubt"] == ["press", "release"]


def test_trembling_after_a_press_does_not_choose_again(tell):
    story = into_row(Story(lockoutMs=900)).wait(550).down().wait(100).up().wait(100)
    for _ in range(5):
        story.down().wait(75).up().wait(75)
    events = acts(tell(story))
    assert events.count(["press", "forward"]) == 1
    assert events.count(["release"]) == 1
    assert ["stop"] not in events


def test_every_press_while_the_chair_moves_stops_at_once(tell):
    story = Story(acceptMs=1000, lockoutMs=2000).wait(1500).call("setMoving", True)
    story.down().wait(25).up().wait(50).down().wait(2000).up().wait(100)
    events = tell(story)
    assert acts(events) == [["stop"], ["stop"]]
    assert lit(events)[-1] == ["stop"]


def test_a_press_that_waits_while_another_starts_the_chair_stops_it(tell):
    story = Story(rows=False, acceptMs=500).wait(1200).down().wait(100)
    story.call("setMoving", True).wait(2000)
    assert acts(tell(story)) == [["stop"]]


def test_a_second_closing_without_an_opening_ends_what_is_held(tell):
    story = into_row(Story()).down().wait(200).call("setMoving", True).wait(200).down().wait(200)
    assert acts(tell(story)) == [["press", "forward"], ["release"], ["stop"]]
    story = Story(rows=False, acceptMs=500).wait(1200).down().wait(200).down().wait(2000)
    assert acts(tell(story)) == []


def test_a_press_means_what_could_be_seen(tell):
    """The light moved at 2000 ms; a press of 2040 ms is meant for what was lit before."""
    story = Story().wait(2000)
    story.now = 2040
    story.down().wait(100).up().wait(100)
    assert lit(tell(story))[-1] == ["forward"]
    story = Story().wait(2000)
    story.now = 2060
    story.down().wait(100).up().wait(100)
    assert lit(tell(story))[-1] == ["arm"]


def test_a_press_that_is_told_late_means_nothing(tell):
    story = into_row(Story())
    story.now += 900
    story.down(story.now - 900).up(story.now - 500).wait(100)
    assert acts(tell(story)) == []
    held = into_row(Story())
    held.now += 900
    assert acts(tell(held.down(held.now - 900).wait(1000))) == []
    moving = into_row(Story()).call("setMoving", True)
    moving.now += 900
    assert acts(tell(moving.down(moving.now - 900))) == [["stop"]]


def test_what_is_lost_ends_and_the_switch_must_be_pressed_anew(tell):
    for loss in (["cancel"], ["offer", [["help"]]], ["configure", TIMES]):
        story = into_row(Story()).down().wait(500).call(*loss).wait(3000)
        events = acts(tell(story))
        assert events == [["press", "forward"], ["release"]], loss


def test_a_switch_held_from_before_and_its_bounces_are_no_press(tell):
    story = Story(acceptMs=0).wait(1500).up()
    story.now += 5
    story.down().wait(1000).up().wait(100)
    assert acts(tell(story)) == []


NOW, IN_ROW = [], ["step", "wait", "down", "wait", "up", "wait", "wait"]


@pytest.mark.parametrize(
    ("times", "begin", "depth"),
    [
        (TIMES | {"stepMs": 200, "lockoutMs": 100}, NOW, 6),
        (TIMES | {"stepMs": 200, "lockoutMs": 100}, IN_ROW, 5),
        (TIMES | {"stepMs": 200, "acceptMs": 0, "debounceMs": 0, "lockoutMs": 0}, IN_ROW, 5),
        (TIMES | {"stepMs": 200, "acceptMs": 0, "debounceMs": 0, "rows": False}, NOW, 6),
    ],
    ids=["from the start", "in a row", "in a row, bare", "one by one, bare"],
)
def test_no_sequence_of_events_breaks_a_rule(plain_page, times, begin, depth):
    found = plain_page.evaluate(ENUMERATE, {"times": times, "begin": begin, "depth": depth})
    assert found["wrong"] == []
    assert found["runs"] == sum(10**n for n in range(depth + 1))
    assert found["presses"] > (300 if begin == NOW else 2000)
    assert found["stops"] > 10_000
