"""Plug-ins' tiles on the driver's page: tests offer, press and read them."""

from fingers import Fingers
from patience import wait_until
from pluginrows import mode, offer

AHEAD, HOME, FOLLOW = mode("ahead"), mode("home"), mode("follow")
TWENTY = [mode(f"mode{n}") for n in range(20)]
SHOWN = "() => [...document.querySelectorAll('.target')].filter(e => e.offsetWidth).map(e => e.id)"
HELD = "() => document.querySelector('.holding')?.id ?? null"


def tiled(person, *rows):
    """The page has taken these plug-ins."""
    offer(person.host, *rows)
    names = [row["names"]["nl"] for row in rows if row["kind"] == "mode"]
    named(person, names[0] if names else "")
    person.state()
    person.forget()


def shown(person):
    return person.page.evaluate(SHOWN)


def moves(person):
    """What moved or stopped since the last call, without repetitions."""
    kinds = []
    for m in person.received("cmd", "mode", "stop"):
        what = (m["k"], m.get("verb") or m.get("mode"), m.get("edge"))
        if not kinds or kinds[-1] != what:
            kinds.append(what)
    person.forget()
    return kinds


def named(person, name):
    """Waits until the first tile of the page of modes has this name."""
    wait_until(lambda: person.page.locator("#plugin-1").count(), "the tiles")
    label = person.page.locator("#plugin-1 .label")
    wait_until(lambda: label.text_content() == name, "its tile")


def more(person):
    """Opens the page of modes."""
    for _ in range(2):
        person.page.locator("#mode").click()
    person.advance(50)
    assert person.data("mode") == "more"


def begin(person, target, by):
    """Begins to press a tile."""
    if by == "gaze":
        person.hover(target)
        person.advance(100, look=target)
    elif by == "touch":
        person.fingers = Fingers(person)
        person.fingers.put(1, target)
    elif by == "mouse":
        person.page.mouse.move(*person.spot(target))
        person.page.mouse.down()
    else:
        person.page.locator(f"#{target}").focus()
        person.page.keyboard.down("Enter")


def end(person, by):
    if by == "touch":
        person.fingers.lift(1)
    elif by == "mouse":
        person.page.mouse.up()
    elif by == "key":
        person.page.keyboard.up("Enter")
