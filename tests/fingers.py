"""Fingers and a stylus on a page's glass, as the browser's own events."""

from patience import wait_until

_FEEL = """() => {
  window.felt = {pointerdown: 0, pointermove: 0, pointerup: 0, pointercancel: 0};
  for (const event in felt) addEventListener(event, () => felt[event]++, true);
}"""


class Fingers:
    """Each has a name; places are px of the viewport."""

    def __init__(self, person):
        self._person = person
        self._page = person.page
        self._page.evaluate(_FEEL)
        self._session = self._page.context.new_cdp_session(self._page)
        self._down = {}

    def touch(self, name, x, y):
        """Puts a finger down, or moves it."""
        moves = name in self._down
        self._down[name] = (x, y)
        self._send(*("touchMove", "pointermove") if moves else ("touchStart", "pointerdown"))

    def put(self, name, target):
        """Puts a finger down on the middle of a target."""
        self.touch(name, *self._person.spot(target))

    def lift(self, name):
        here = {name: self._down.pop(name)}
        self._send("touchEnd", "pointerup", here)

    def cancel(self):
        """The system takes the touches away: a gesture, a call."""
        self._down.clear()
        self._send("touchCancel", "pointercancel")

    def _send(self, kind, event, where=None):
        """Sends the touches, and waits for the page's event: another call may overtake it."""
        points = [{"x": x, "y": y, "id": n} for n, (x, y) in (where or self._down).items()]
        felt = self._page.evaluate("felt")
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        wait_until(lambda: self._page.evaluate("felt")[event] > felt[event], f"the page's {event}")


class Stylus:
    """Taps, and is lifted until the screen no longer detects it."""

    def __init__(self, person):
        self._person = person
        self._session = person.page.context.new_cdp_session(person.page)

    def tap(self, target):
        """A press on a target, and its release."""
        x, y = self._person.spot(target)
        at = {"x": x, "y": y, "button": "left", "clickCount": 1, "pointerType": "pen"}
        for kind in ("mousePressed", "mouseReleased"):
            self._session.send("Input.dispatchMouseEvent", {"type": kind, **at})
        self.leave()

    def leave(self):
        self._person.page.evaluate(
            "document.documentElement.dispatchEvent("
            "new PointerEvent('pointerleave', {pointerType: 'pen'}))"
        )
