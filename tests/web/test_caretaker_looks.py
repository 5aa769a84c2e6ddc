"""How the caretaker's page looks: on narrow phones and wide screens, whatever it says."""

import pytest

from fakehost import ARMED, picture
from pagelooks import CUT_OFF, on_every_screen
from patience import wait_until

pytestmark = pytest.mark.browser

# Between neighbouring words of the tabs, and beside the emergency stop, px.
GAPS = """
() => {
  const words = [...document.querySelectorAll("nav button")].map(e => {
    const range = document.createRange();
    range.selectNodeContents(e);
    return range.getBoundingClientRect();
  });
  const between = words.slice(1).map((box, n) => box.left - words[n].right);
  const last = document.querySelector("#emergency").getBoundingClientRect();
  return [...between, innerWidth - last.right];
}
"""

LOOKS = {
    "watching": {"simulated": True},
    "driving": {"you": True, "owner": "caretaker", "motion": "drive", "output_permille": [358, 0]},
    "override": {
        "override": "obstacle_forward",
        "decisions": {"forward": "blocked", "left": "slow", "right": "free", "backward": "unknown"},
        "clearance": {"forward": 0.3, "backward": None, "left": 22.0, "right": 180.0},
        "view": {"forward": "seen", "backward": "unseen", "left": "seen", "right": "seen"},
    },
    "emergency": {"state": "disarmed", "level": "error", "message": "emergency"},
}


def test_how_it_looks(caretaker, host, artefact):
    host.show(picture(), 0)
    wait_until(lambda: host.acknowledged, "the picture")
    for number, (name, look) in enumerate(LOOKS.items(), start=1):
        caretaker.state(**ARMED | {"you": False, "view": None, "clearance": None} | look)
        caretaker.advance(1100)
        host.show(picture(), number)
        wait_until(lambda n=str(number): n in host.acknowledged, "the picture")
        caretaker.advance(25)
        for screen in on_every_screen(caretaker.page, [(360, 640), (390, 844), (1366, 768)]):
            artefact(f"caretaker-{name}-{screen[0]}")
            assert caretaker.page.evaluate(CUT_OFF) == [], (name, screen)
            assert caretaker.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            assert min(caretaker.page.evaluate(GAPS)) > 4.0, screen
