"""Accessibility: names for screen readers, and legible words with every colour blindness."""

import re

import pytest

from fakehost import ARMED, OFF, picture
from patience import wait_until
from webperson import CARETAKER, Driver

pytestmark = pytest.mark.browser

# Full colour blindness of each kind on linear RGB (Machado, Oliveira, Fernandes 2009, severity 1).
EYES = {
    "full": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
# Every element with words of its own: its colour, and the backgrounds under it, nearest first.
WORDS = """
() => [...document.querySelectorAll("body *")].filter(e => {
  const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
  const box = e.getBoundingClientRect();
  return own && box.width && getComputedStyle(e).visibility === "visible" && !e.closest(".drive");
}).map(e => {
  const under = [];
  let opacity = 1;
  for (let at = e; at; at = at.parentElement) {
    under.push(getComputedStyle(at).backgroundColor);
    opacity *= getComputedStyle(at).opacity;
  }
  const size = parseFloat(getComputedStyle(e).fontSize);
  return { words: e.textContent.trim(), colour: getComputedStyle(e).color, under, opacity, size };
})
"""
NAMES = {
    "driver": {"Vooruit", "Links", "Rechts", "STOP", "Hulp"},
    "caretaker": {"STOP", "Overnemen", "Rijden", "Instellen", "Koppelen"},
}


def rgba(text):
    """A computed colour as red, green, blue 0..1 and opacity."""
    numbers = [float(n) for n in re.findall(r"[\d.]+", text)]
    return [n / 255 for n in numbers[:3]], numbers[3] if len(numbers) > 3 else 1.0


def over(top, opacity, bottom):
    return [opacity * a + (1 - opacity) * b for a, b in zip(top, bottom, strict=True)]


def brightness(colour, eyes):
    """Relative luminance (WCAG) with this colour vision."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    seen = [min(1, max(0, sum(m * c for m, c in zip(row, linear, strict=True)))) for row in eyes]
    return 0.2126 * seen[0] + 0.7152 * seen[1] + 0.0722 * seen[2]


def contrasts(item, picture_shade):
    """The contrast of its words for every colour vision, over a picture of that shade."""
    layers = []
    for text in item["under"]:
        colour, opacity = rgba(text)
        layers.append((colour, opacity))
        if opacity == 1:
            break
    ground = [picture_shade] * 3
    for colour, opacity in reversed(layers):
        ground = over(colour, opacity, ground)
    ink = over(rgba(item["colour"])[0], item["opacity"], ground)
    for name, eyes in EYES.items():
        light, dark = sorted((brightness(ink, eyes), brightness(ground, eyes)), reverse=True)
        yield name, (light + 0.05) / (dark + 0.05)


def judge(page):
    items = page.evaluate(WORDS)
    assert len(items) > 8
    for item in items:
        for shade in (0.0, 1.0):
            for eyes, contrast in contrasts(item, shade):
                least = 3.0 if item["size"] >= 24 else 4.5  # WCAG AA: large and other words
                assert contrast >= least, (item["words"], eyes, round(contrast, 2), item)


def test_every_word_is_legible_for_all_eyes(driver, host):
    for contrast in ("normal", "high", "night"):
        check_contrast(driver, host, contrast)


def check_contrast(driver, host, contrast):
    driver.state(**ARMED | OFF)  # while it drives it keeps its look
    host.profiles.change({"save": {"id": "1", "contrast": contrast}}, True)
    driver.state()
    wait_until(lambda: driver.data("contrast") == contrast, "the look")
    for state in (
        {
            "state": "armed",
            "you": True,
            "owner": "driver",
            "decisions": {"forward": "blocked", "left": "slow", "right": "free"},
        },
        {"level": "warning", "message": "camera_lost", "simulated": True, "call": True},
        {"level": "error", "message": "emergency", "override": "obstacle_left"},
        {"state": "disarmed", "override": "none"},
    ):
        driver.state(**state)
        driver.advance(25)
        assert driver.data("contrast") == contrast
        judge(driver.page)


def test_drive_targets_have_their_words_on_a_dark_edge(driver):
    """Over a picture of any shade: white words with a dark shadow of their own."""
    for name in ("forward", "left", "right"):
        style = driver.page.evaluate(
            "id => getComputedStyle(document.getElementById(id)).textShadow", name
        )
        assert "rgba(0, 0, 0, 0.8)" in style


def test_a_decision_differs_in_more_than_colour(driver):
    shown = {}
    for decision in ("free", "slow", "blocked", "unknown"):
        driver.state(decisions={"forward": decision, "left": "free", "right": "free"})
        sign = "getComputedStyle(document.querySelector('#line-front .word'), '::before').content"
        shown[decision] = (driver.text("#line-front .word"), driver.page.evaluate(sign))
    assert len({word for word, _ in shown.values()}) == 4
    assert len({sign for _, sign in shown.values()}) == 4


def tree(page):
    """Chromium's accessibility tree: role, name and description of all that is not ignored."""
    session = page.context.new_cdp_session(page)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    value = lambda node, key: node.get(key, {}).get("value", "")  # noqa: E731
    return [
        (value(node, "role"), value(node, "name"), value(node, "description"))
        for node in nodes
        if not node["ignored"]
    ]


def test_the_drivers_page_speaks(driver, host):
    host.show(picture(), 1)
    wait_until(lambda: host.acknowledged, "the picture")
    driver.state(decisions={"forward": "slow", "left": "free", "right": "blocked"})
    nodes = tree(driver.page)
    buttons = {name: text for role, name, text in nodes if role == "button"}
    assert all(buttons), "a button without a name"
    missing = [label for label in NAMES["driver"] if not any(n.startswith(label) for n in buttons)]
    assert missing == []  # "Hulp" goes on with who hears it
    assert "langzaam" in buttons["Vooruit"]
    assert "bezet" in buttons["Rechts"]
    roles = [role for role, _, _ in nodes]
    assert roles.count("status") >= 2
    driver.state(override="obstacle_forward")
    assert "alert" in [role for role, _, _ in tree(driver.page)]


def test_the_caretakers_page_speaks_and_is_legible(page, host):
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    person = Driver(page, host)
    host.state.update(you=False, call=True, decisions={"forward": "blocked", "left": "slow"})
    person.open("caretaker")
    nodes = tree(page)
    buttons = {name for role, name, _ in nodes if role == "button"}
    assert NAMES["caretaker"] <= buttons
    assert all(buttons)
    assert [node for node in nodes if node[0] in ("slider", "application") and not node[1]] == []
    judge(page)
