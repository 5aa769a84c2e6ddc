"""Fingers and a stylus on a page's glass, as the browser's own events."""

from patience import wait_until


class Fingers:
    """Each has a name; places are px of the viewport."""

    def __init__(self, person):
        self._person = person
        self._page = person.page
        self._page.evaluate(
            "() => { window.felt = 0; addEventListener('pointermove', () => felt++); }"
        )
        self._session = self._page.context.new_cdp_session(self._page)
        self._down = {}

    def touch(self, name, x, y):
        """Puts a finger down, or moves it."""
        kind = "touchMove" if name in self._down else "touchStart"
        felt = self._page.evaluate("felt")
        self._down[name] = (x, y)
        self._send(kind, self._down)
        if kind == "touchMove":  # the browser tells the page with its next frame
            wait_until(lambda: self._page.evaluate("felt") > felt, "the finger's move")

    def put(self, name, target):
        """Puts a finger down on the middle of a target."""
        self.touch(name, *self._person.spot(target))

    def lift(self, name):
        self._send("touchEnd", {name: self._down.pop(name)})

    def cancel(self):
        """The system takes the touches away: a gesture, a call."""
        self._down.clear()
        self._session.send("Input.dispatchTouchEvent", {"type": "touchCancel", "touchPoints": []})

    def _send(self, kind, where):
        points = [{"x": x, "y": y, "id": n} for n, (x, y) in where.items()]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


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
