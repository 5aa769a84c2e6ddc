"""Marks on the floor, tapped on a phone: the page's marks give the camera's true calibration."""

import functools
import io
import math
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image, ImageDraw

from fingers import Fingers
from gazechair.first_drive.floor_marks import FloorMarks, marks_of
from gazechair.picture.floor_store import FloorStore
from gazesim.floor_view import Eye, Floor, FloorView
from layoutshift import WATCH, take
from pagelooks import on_every_screen
from patience import wait_until

pytestmark = pytest.mark.browser

EYE = Eye(640, 480, field_deg=68.0, height_m=1.21, down_deg=27.0, left_deg=2.0, forward_m=0.25)
ROW = {"step": "camera", "done": False, "refused": "", "size": [640, 480]}
ROW |= {"found": None, "lines": []}
IDLE = {"step": "", "lines": [], "pulses": 0, "straight": 0, "asks": "", "ended": None}
FAILED = {"step": "camera", "ok": False, "reason": "first_failed", "detail": "the marks"}
FAILED |= {"error": "floor_residual", "fields": {"mark": 2, "cm": 14.2}}
KNOWN = {"residual_mm": 12, "fits": True}
OFF = (0.015, -0.01)  # where a finger taps beside a mark, in shares of the picture
LINES = [{"m": 2.0, "px": [[0.1, 0.55], [0.5, 0.5], [0.9, 0.55]]}]


PLACES = [(1.2, 0.3), (1.2, -0.3), (1.8, 0.5), (1.8, -0.5), (2.5, 0.7), (2.5, -0.7), (2.0, 0.0)]


@functools.cache
def marked_floor():
    """A picture of a floor with sheets of paper on it."""
    image = Image.open(io.BytesIO(FloorView(EYE, Floor()).jpeg(0.0, 0.0, 0.0)))
    draw = ImageDraw.Draw(image)
    for x, y in PLACES:
        corners = [(x - 0.05, y - 0.05), (x - 0.05, y + 0.05), (x + 0.05, y + 0.05)]
        corners.append((x + 0.05, y - 0.05))
        draw.polygon([EYE.pixel(*corner) for corner in corners], fill="white")
    out = io.BytesIO()
    image.save(out, "JPEG", quality=85)
    return out.getvalue()


class Marking:
    """A caretaker with a phone, and the host's answers."""

    def __init__(self, caretaker):
        self.person, self.page, self.host = caretaker, caretaker.page, caretaker.host
        self.jpeg = marked_floor()
        self.host.show(self.jpeg, 1)
        self.now(ROW)
        self.page.locator("#tab-settings").click()
        self.page.locator("#tab-first").click()
        steps = self.page.locator(".first li")
        caretaker.wait_until(lambda: caretaker.advance(600) or steps.count(), "the steps")

    def now(self, row, **run):
        """Set the host's answer from now on, and wait until the page has shown it."""
        answer = (200, {"steps": [row], "run": {**IDLE, **run}})
        self.host.replies |= {"GET /first-drive": answer, "POST /first-drive": answer}
        for _ in range(3):
            self.person.advance(600)
            self.person.answered()

    def open(self):
        self.page.locator(".first li .controls button").click()
        # The picture has moved over: where it is now, the phone has drawn it.
        wait_until(lambda: self.page.locator("#marking .view #picture").count(), "the picture")

    def press(self, text):
        self.page.locator("#marking button", has_text=text).click()

    def status(self):
        return self.page.locator("#marking .status-text").inner_text()

    def place(self):
        """The requested place of the mark: metres ahead and to the left."""
        ahead, aside = (float(one.input_value()) for one in self.page.locator("input").all()[-2:])
        side = float(self.page.locator("#marking select").input_value())
        return ahead / 100, side * aside / 100

    def box(self):
        return self.page.locator("#marking .floor").bounding_box()

    def tap(self, u, v):
        """Tap a spot, in fractions of the picture."""
        box = self.box()
        self.page.mouse.click(box["x"] + u * box["width"], box["y"] + v * box["height"])

    def drag(self, du, dv):
        """Move the enlarged picture by fractions of its frame."""
        box = self.box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + du * box["width"], y + dv * box["height"], steps=5)
        self.page.mouse.up()

    def mark(self):
        """Tap beside the requested mark, as a finger does; correct the cross; continue."""
        at = EYE.pixel(*self.place())
        u, v = at[0] / EYE.width_px, at[1] / EYE.height_px
        self.tap(u + OFF[0], v + OFF[1])
        assert "kruis" in self.page.locator("#marking .panel p").first.inner_text()
        self.drag(OFF[0] * 4, OFF[1] * 4)

    def posted(self):
        return [request["value"] for path, request in self.host.posted if path == "/first-drive"]


@pytest.fixture
def marking(caretaker):
    return Marking(caretaker)


def test_marks_tapped_on_a_phone_calibrate_the_camera(marking, tmp_path):
    marking.page.evaluate(WATCH)
    marking.open()
    fit = marking.page.locator("#marking .panel .strong")
    for number in range(8):
        assert fit.is_disabled() == (number < 6)
        marking.mark()
        if number < 7:
            marking.press("Volgende")
        if number == 4:
            marking.host.show(marking.jpeg, 2)
            wait_until(lambda: "2" in marking.host.acknowledged, "a new picture")
            marking.person.run_for(50)
            marking.person.screenshot("first_drive_marks")
    assert take(marking.page) == [], "nothing moves under a finger"
    marking.press("Uitrekenen")
    wait_until(marking.posted, "the marks")
    rows = marks_of(marking.posted()[0])
    assert rows is not None
    assert len(rows) == 8
    # The page's marks give the host the camera's true pose.
    store = FloorStore(tmp_path)
    FloorMarks(store, lambda: marking.jpeg).fit(rows)
    known = store.get()
    assert known is not None
    for place in ((1.5, 0.2), (2.2, -0.4)):
        pixel = np.array((EYE.pixel(*place),))
        assert math.dist(known.camera.floor_m(pixel)[0], place) < 0.03
    marking.now({**ROW, "done": True, "found": KNOWN, "lines": LINES}, ended={**FAILED, "ok": True})
    assert "1,2 cm op 2 m" in marking.status()
    points = marking.page.locator("polyline.metre").get_attribute("points").split()
    box = marking.box()
    assert points[1] == f"{round(0.5 * box['width'])},{round(0.5 * box['height'])}"
    marking.press("Sluiten")
    assert marking.page.locator(".see .view #picture").count() == 1
    assert marking.page.locator("#marking").count() == 0


def test_a_refusal_names_the_mark_which_can_be_moved(marking):
    marking.open()
    for number in range(6):
        marking.mark()
        if number < 5:
            marking.press("Volgende")
    marking.press("Uitrekenen")
    wait_until(marking.posted, "the marks")
    before = marking.posted()[0]
    marking.now(ROW, ended=FAILED)
    assert "verschillen 14,2 cm" in marking.status()
    assert "eerst merkteken 2" in marking.status()
    assert marking.page.locator("text.worst").inner_html() == "2"
    # It is the one that is shown: a tap moves it, its measure can be changed.
    assert marking.place() == (1.2, -0.3)
    marking.tap(0.75, 0.9)
    assert marking.page.locator(".worst").count() == 0
    marking.page.locator("#marking .floor").press("ArrowRight")
    ahead = marking.page.locator("#marking input").nth(0)
    ahead.fill("")  # none is not 0
    ahead.blur()
    assert marking.place() == (1.2, -0.3)
    ahead.fill("131")
    marking.press("Uitrekenen")
    wait_until(lambda: len(marking.posted()) == 2, "the marks again")
    after = marking.posted()[1]
    assert [one for one, other in zip(before, after, strict=True) if one != other] == [before[1]]
    assert after[1] == pytest.approx([0.7505, 0.9, 131, -30], abs=0.004)


def test_an_old_answer_is_not_taken_for_the_new_fits(marking):
    marking.now(ROW, ended=FAILED)
    marking.open()
    assert "Nog 6 nodig" in marking.status()
    for number in range(6):
        marking.mark()
        if number < 5:
            marking.press("Volgende")
    marking.now(ROW, ended=FAILED)
    assert "14,2" not in marking.status()


def test_it_is_offered_only_while_driving_is_off(marking):
    marking.open()
    marking.mark()
    marking.now({**ROW, "refused": "setting_while_armed"})
    assert marking.page.locator("#marking").count() == 0
    assert marking.page.locator(".see .view #picture").count() == 1
    marking.page.locator(".first li .controls button").click()
    assert marking.page.locator("#marking").count() == 0
    # Afterwards all marks are at other places in the picture.
    marking.now(ROW)
    marking.open()
    assert "Nog 6 nodig" in marking.status()
    assert marking.page.locator("path.cross").count() == 0


def test_what_is_said_over_the_picture_is_no_mark_and_a_stop_stays_a_stop(marking):
    marking.open()
    marking.person.state(call=True, received=True)
    marking.page.locator("#answer").click()
    wait_until(lambda: marking.person.received("call"), "the answer to the call")
    assert marking.page.locator("path.cross").count() == 0
    marking.page.locator("#stop").click()
    assert marking.person.received("stop")


def test_picture_words_and_buttons_have_room(marking):
    page = marking.page
    for size in on_every_screen(page, [(360, 640), (390, 844), (844, 390), (1280, 800)]):
        marking.open()
        foot = page.locator("footer").bounding_box()
        boxes = [marking.box()] + [
            one.bounding_box() for one in page.locator("#marking .panel > *").all()
        ]
        assert all(box["width"] > 100 for box in boxes), size
        assert boxes[0]["width"] / boxes[0]["height"] == pytest.approx(4 / 3, abs=0.02), size
        assert boxes[0]["y"] + boxes[0]["height"] <= foot["y"] + 1, size
        assert all(a["y"] + a["height"] <= b["y"] + 1 for a, b in pairwise(boxes[1:])), size
        page.locator("#marking button", has_text="Sluiten").scroll_into_view_if_needed()
        marking.press("Sluiten")


class Touched:
    """Fingers on a picture with one mark, at (0.4, 0.6); places are fractions of the picture."""

    def __init__(self, marking):
        self._marking = marking
        marking.open()
        self._box = marking.box()
        self._fingers = Fingers(marking.person)
        self.lift = self._fingers.lift
        self._crosses = marking.page.locator("path.cross.ink")
        self.touch(1, 0.4, 0.6)
        self.lift(1)
        wait_until(lambda: self._crosses.count() == 1, "the mark")

    def touch(self, finger, u, v):
        x, y, wide, high = (self._box[name] for name in ("x", "y", "width", "height"))
        self._fingers.touch(finger, x + u * wide, y + v * high)

    def mark(self):
        """Where it is on the whole picture."""
        self._marking.press("Hele beeld")
        path = self._crosses.get_attribute("d")
        x, y = (float(one) for one in path[1:].split("h")[0].split())
        return (x + 14) / self._box["width"], y / self._box["height"]


def test_a_finger_moves_the_enlarged_picture(marking):
    touched = Touched(marking)
    touched.touch(1, 0.5, 0.5)
    for n in range(1, 11):
        touched.touch(1, 0.5 + 0.02 * n, 0.5 - 0.01 * n)
    touched.lift(1)
    # A fifth to the right on a picture four times as large, a tenth up.
    assert touched.mark() == pytest.approx((0.4 - 0.05, 0.6 + 0.025), abs=0.004)


def test_of_two_fingers_the_newest_moves_the_picture_and_nothing_jumps(marking):
    touched = Touched(marking)
    touched.touch(1, 0.2, 0.2)
    touched.touch(2, 0.8, 0.8)
    for n in range(1, 5):  # as if to enlarge it
        touched.touch(1, 0.2 - 0.01 * n, 0.2)
        touched.touch(2, 0.8 - 0.02 * n, 0.8)
    touched.lift(2)
    touched.touch(1, 0.5, 0.5)
    touched.lift(1)
    assert touched.mark() == pytest.approx((0.4 + 0.02, 0.6), abs=0.004)
