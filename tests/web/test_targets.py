"""What looks and presses do: the page's state machine, in Chromium, in simulated time."""

import random

import pytest

from gazechair.config.settings import Config
from gazechair.people.profiles.house import house_fields

pytestmark = pytest.mark.browser

TIMES = {name: field.default for name, field in house_fields(Config()).items()}

RUN = """
async (steps) => {
  const { Targets } = await import("/static/targets.js");
  const events = [];
  let now = 0;
  const on = { view() {} };
  for (const kind of ["drive", "act", "tap"]) {
    on[kind] = (...rest) => events.push([Math.round(now), kind, ...rest]);
  }
  on.stop = () => events.push([Math.round(now), "stop"]);
  const targets = new Targets(on);
  targets.setTimes(50, 300);
  for (const [at, call, ...rest] of steps) targets[call](...rest, (now = at));
  return events;
}
"""


class Story:
    """Builds a sequence of events: the driver is armed and has looked at the middle already."""

    def __init__(self, mode="continuous", armed=True, times=None):
        self.now = 0
        self.steps = [[0, "configure", {**TIMES, **(times or {})}]]
        self.call("setMode", mode)
        self.call("setArmed", armed)
        self.look(None, 400)
        self.began = self.now

    def call(self, name, *rest):
        self.steps.append([self.now, name, *rest])
        return self

    def look(self, target, ms):
        """A gaze of 40 Hz on the target."""
        return self._pass(ms, ["hover", target])

    def wait(self, ms):
        """Time passes and the pointer does not move."""
        return self._pass(ms, None)

    def _pass(self, ms, event):
        end = self.now + ms
        while self.now < end:
            if event:
                self.call(*event)
            self.call("tick")
            self.now += 25
        return self

    def press(self, target, source="mouse"):
        return self.call("press", target, source)

    def release(self, source="mouse"):
        return self.call("release", source)


@pytest.fixture
def tell(plain_page):
    """Runs a story and returns its outputs: [ms since its beginning, kind, ...]."""

    def run(story):
        events = plain_page.evaluate(RUN, story.steps)
        return [[at - story.began, *rest] for at, *rest in events]

    return run


def kinds(events):
    return [entry[1] for entry in events]


def drives(events):
    return [entry for entry in events if entry[1] == "drive"]


def test_gaze_starts_after_the_dwell_and_says_so_every_heartbeat(tell):
    events = tell(Story().look("forward", 1000))
    assert events[0] == [600, "drive", "forward", "continuous", 1]
    assert [at for at, *_ in events] == list(range(600, 1000, 50))
    assert {tuple(rest) for _, *rest in events} == {("drive", "forward", "continuous", 1)}


def test_a_glance_shorter_than_the_dwell_does_nothing(tell):
    assert tell(Story().look("forward", 575).look(None, 2000)) == []


def test_a_blink_during_the_dwell_only_delays_it(tell):
    events = tell(Story().look("left", 400).look(None, 100).look("left", 400))
    assert events[0] == [700, "drive", "left", "continuous", 1]


def test_glances_with_pauses_never_add_up_to_a_dwell(tell):
    story = Story()
    for _ in range(10):
        story.look("left", 400).look(None, 250)
    assert tell(story) == []


def test_looking_away_stops_after_the_grace(tell):
    events = tell(Story().look("forward", 700).look(None, 1000))
    assert events[-1] == [900, "stop"]
    assert drives(events)[-1][0] < 700


def test_looking_away_within_the_grace_keeps_the_same_command(tell):
    events = tell(Story().look("forward", 700).look(None, 175).look("forward", 200))
    assert "stop" not in kinds(events)
    assert {entry[4] for entry in events} == {1}


def test_a_frozen_pointer_counts_as_leaving(tell):
    events = tell(Story().look("forward", 700).wait(2000))
    last_proof = 675
    assert events[-1] == [last_proof + 500, "stop"]
    # The board's 300 ms run out when the pointer is 500 ms old: no proof later than 200 ms.
    assert drives(events)[-1][0] <= last_proof + 200


def test_a_frozen_pointer_never_completes_a_dwell(tell):
    assert tell(Story().look("forward", 375).wait(2000)) == []


def test_a_page_that_stalled_does_not_resume_by_a_late_return(tell):
    story = Story().look("forward", 700)
    story.now += 800  # no event, no tick
    events = tell(story.look("forward", 200))
    assert events[-1][1:] == ["stop"]
    assert drives(events)[-1][0] < 700


def test_after_a_stop_the_gaze_must_leave_every_drive_target_for_300_ms(tell):
    story = Story().look("forward", 700).look(None, 200).look("left", 1500)
    events = tell(story)
    assert events[-1][1] == "stop"  # only 200 ms away: left does not start
    events = tell(Story().look("forward", 700).look(None, 600).look("left", 700))
    assert events[-1][1:] == ["drive", "left", "continuous", 2]


def test_steering_while_moving_needs_less_time_than_starting(tell):
    events = tell(Story().look("forward", 700).look("left", 1000))
    started = [entry for entry in drives(events) if entry[2] == "left"]
    assert started[0] == [900, "drive", "left", "continuous", 2]
    assert [at for at, kind, *_ in events if kind == "stop"] in ([], [900])
    assert not [entry for entry in drives(events) if entry[2] == "forward" and entry[0] > 700]


def test_a_glance_at_another_direction_and_back_goes_on(tell):
    events = tell(Story().look("forward", 700).look("left", 150).look("forward", 500))
    assert {entry[2] for entry in drives(events)} == {"forward"}
    assert "stop" not in kinds(events)


def test_a_slow_steering_dwell_outlasts_the_grace_that_stops(tell):
    times = {"dwell_ms": 600, "steer_dwell_ms": 500, "button_dwell_ms": 1000}
    times |= {"leave_grace_ms": 200, "pointer_stale_ms": 500}
    events = tell(Story(times=times).look("forward", 700).look("left", 1000))
    assert [900, "stop"] in events
    assert [1200, "drive", "left", "continuous", 2] in events


def test_a_look_away_while_steering_needs_rest_and_the_whole_dwell_again(tell):
    events = tell(Story().look("forward", 700).look("left", 100).look(None, 225).look("left", 2000))
    assert "left" not in {entry[2] for entry in drives(events)}


def test_steps_are_never_steered(tell):
    events = tell(Story("step").look("forward", 700).look("left", 3000))
    assert {entry[2] for entry in drives(events)} == {"forward"}


def test_gaze_drives_only_when_armed(tell):
    assert tell(Story(armed=False).look("forward", 2000)) == []


def test_disarming_ends_what_is_held(tell):
    story = Story().look("forward", 700).call("setArmed", False).look("forward", 1000)
    events = tell(story)
    assert events[-1] == [700, "stop"]


def test_stop_acts_on_entry(tell):
    events = tell(Story().look("forward", 700).look("stop", 25))
    assert events[-1] == [700, "stop"]


def test_stop_says_it_once_for_each_entry(tell):
    events = tell(Story().look("stop", 1000).look(None, 100).look("stop", 1000))
    assert events == [[0, "stop"], [1100, "stop"]]


@pytest.mark.parametrize("source", ["mouse", "touch", "key ArrowUp"])
def test_a_press_starts_at_once_needs_no_movement_and_ends_with_the_release(tell, source):
    events = tell(Story().press("forward", source).wait(1000).release(source).wait(500))
    assert events[0] == [0, "drive", "forward", "continuous", 1]
    assert [at for at, *_ in drives(events)] == list(range(0, 1000, 50))
    assert events[-1] == [1000, "stop"]


def test_each_press_has_a_new_edge_and_needs_no_rest(tell):
    story = Story()
    for _ in range(3):
        story.press("left").wait(300).release().wait(25)
    assert sorted({entry[4] for entry in drives(tell(story))}) == [1, 2, 3]


def test_dragging_off_the_target_stops_at_once_and_returning_does_not_resume(tell):
    story = Story().press("forward").wait(300).call("drag", None, "mouse").wait(300)
    events = tell(story.call("drag", "forward", "mouse").wait(300).release().wait(100))
    assert events[-1] == [300, "stop"]


def test_a_released_mouse_that_still_hovers_does_not_start_again(tell):
    events = tell(Story().press("forward").wait(500).release().look("forward", 3000))
    assert events[-1] == [500, "stop"]


def test_the_newest_press_wins_and_its_release_stops(tell):
    story = Story().press("forward", "key ArrowUp").wait(200).press("left", "key ArrowLeft")
    events = tell(
        story.wait(200).release("key ArrowUp").wait(200).release("key ArrowLeft").wait(200)
    )
    assert [entry[2] for entry in drives(events) if entry[0] >= 200] == ["left"] * 8
    assert events[-1] == [600, "stop"]


def test_a_tap_in_continuous_mode_earns_a_hint(tell):
    events = tell(Story().press("forward").wait(100).release())
    assert [entry[1:] for entry in events[-2:]] == [["stop"], ["tap", "forward"]]


def test_a_step_is_said_for_150_ms_with_one_edge_and_never_again(tell):
    events = tell(Story("step").look("left", 5000))
    assert events == [[at, "drive", "left", "step", 1] for at in (600, 650, 700)]


def test_the_next_step_needs_leaving_and_returning(tell):
    story = Story("step").look("left", 1000).look(None, 400).look("left", 1000)
    events = tell(story)
    assert kinds(events) == ["drive"] * 6  # leaving does not abort the step
    assert [entry[4] for entry in events] == [1, 1, 1, 2, 2, 2]


def test_a_flicker_off_the_target_is_no_next_step(tell):
    events = tell(Story("step").look("left", 1000).look(None, 100).look("left", 2000))
    assert {entry[4] for entry in events} == {1}


def test_a_pressed_step_runs_on_after_the_release(tell):
    events = tell(Story("step").press("right").wait(50).release().wait(500))
    assert events == [[0, "drive", "right", "step", 1]]


def test_changing_the_mode_ends_what_is_held(tell):
    events = tell(Story().press("forward", "key").wait(100).call("setMode", "step").wait(500))
    assert events[-1] == [100, "stop"]


@pytest.mark.parametrize("name", ["arm", "mode"])
def test_a_button_acts_after_one_second_of_looking_once(tell, name):
    assert tell(Story().look(name, 975)) == []
    story = Story()
    assert tell(story.look(name, 5000)) == [[1000, "act", name, story.began]]


def test_a_button_acts_on_the_release_of_a_click(tell):
    story = Story().wait(25)
    assert tell(story.press("arm").wait(50).release()) == [[75, "act", "arm", story.began + 25]]
    story = Story().press("arm").wait(50).call("drag", None, "mouse").wait(50).release()
    assert tell(story) == []


def test_cancel_stops_at_once_and_the_gaze_must_rest_first(tell):
    events = tell(Story().look("forward", 700).call("cancel").look("forward", 3000))
    assert events[-1] == [700, "stop"]


@pytest.mark.parametrize("seed", range(40))
def test_after_a_stop_no_edge_ever_drives_again(tell, seed):
    """Random events: an edge never returns after any other message, edges only grow."""
    rng = random.Random(seed)
    names = ["forward", "left", "right", "backward", "stop", "arm", "mode", None]
    story = Story(rng.choice(["continuous", "step"]))
    for _ in range(150):
        target = rng.choice(names)
        source, act = rng.choice(["mouse", "touch", "key"]), rng.randrange(8)
        if act < 3:
            story.look(target, rng.randrange(0, 1200, 25))
        elif act == 3:
            story.press(target, source).wait(rng.randrange(0, 600, 25))
        elif act == 4:
            story.release(source)
        elif act == 5:
            story.call("drag", target, source)
        elif act == 6:
            story.call(rng.choice(["cancel", "stop"])).wait(rng.randrange(0, 600, 25))
        else:
            story.now += rng.randrange(0, 1500)  # the page stalls
    events = [entry for entry in tell(story) if entry[1] in ("drive", "stop")]
    last, stopped_edge = 0, 0
    for _at, kind, *rest in events:
        if kind == "stop":
            stopped_edge = last
        else:
            edge = rest[2]
            assert edge >= last
            assert edge > stopped_edge
            last = edge
    assert last > 0
