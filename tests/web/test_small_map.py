"""The driver's small map: calm, no target, shown only where the status leaves room."""

import pytest

from layoutshift import WATCH, take
from mapanswers import CHANGED, DETAILS, PICTURE, WHERE
from patience import wait_until

pytestmark = pytest.mark.browser


def drawn_on(page) -> str:
    """The present content of the small map's canvas; a screenshot may show an older frame."""
    return page.evaluate("document.getElementById('small-map').toDataURL()")


def picture_came(page) -> None:
    """Wait until the small map has drawn its picture."""
    some = """() => {
      const canvas = document.getElementById("small-map");
      const { width, height } = canvas;
      if (!width || !height) return false;
      const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
      return data.some((part) => part > 0);
    }"""
    wait_until(lambda: page.evaluate(some), "the picture")


def drawn_at(driver, where) -> str:
    """The small map 100 ms after that state of the host."""
    driver.state(where=where)
    driver.run_for(100)
    return drawn_on(driver.page)


def test_a_driver_sees_a_small_map_that_is_calm_and_no_target(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small = page.locator("#small-map")
    driver.advance(3000)
    assert small.count() == 0  # not even fetched
    page.evaluate(WATCH)

    def shown() -> bool:
        driver.state(where=WHERE)
        driver.run_for(500)
        return small.count() == 1 and small.is_visible()

    wait_until(shown, "the small map")
    driver.screenshot("map_small")
    assert take(page) == [], "nothing else has moved"
    box = small.bounding_box()
    at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    under = "([x, y]) => document.elementFromPoint(x, y).closest('#small-map') === null"
    assert page.evaluate(under, at)
    picture_came(page)
    # The chair on it has just moved, whenever that was.
    for x in (3.5, 2.5):
        was = drawn_at(driver, WHERE)
        moved = {**WHERE, "x": x}
        wait_until(lambda: drawn_at(driver, moved) != was, "the chair to move")  # noqa: B023
    before = drawn_on(page)
    for _ in range(15):
        assert drawn_at(driver, {**WHERE, "x": 4.0}) == before  # at most every 2 s

    def tell(**news) -> None:
        """Send states for 2.5 s, as a host does."""
        for _ in range(5):
            driver.state(**news)
            driver.run_for(500)

    tell(where={**WHERE, "x": 4.0})
    assert drawn_on(page) != before
    # A message needs the room; and without a known pose there is no map.
    driver.state(level="error", message="board_lost")
    driver.run_for(200)
    assert not small.is_visible()
    driver.state(level="ok", message="ok")
    driver.run_for(200)
    assert small.is_visible()
    tell(where=None)
    assert not small.is_visible()


def test_a_style_sheet_that_comes_after_the_map_hides_nothing(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    held = []
    page.route("**/small_map.css", lambda route: held.append(route))
    small = page.locator("#small-map")

    def open_but_for_that() -> bool:
        driver.state(where=WHERE)
        driver.run_for(500)
        return held and small.get_attribute("data-fits") is not None

    driver.wait_until(open_but_for_that, "the map")
    held[0].continue_()
    driver.wait_until(small.is_visible, "the small map")
    picture_came(page)


def test_it_is_drawn_anew_on_a_tablet_that_was_turned(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small = page.locator("#small-map")

    def shown() -> bool:
        driver.state(where=WHERE)
        driver.run_for(500)
        return small.count() == 1 and small.is_visible()

    wait_until(shown, "the small map")
    picture_came(page)
    page.set_viewport_size({"width": 1080, "height": 1920})
    fits = "one => one.width === one.clientWidth && one.height === one.clientHeight"
    wait_until(lambda: small.evaluate(fits), "the other shape")
    picture_came(page)


def test_a_map_that_does_not_come_is_asked_for_again(driver):
    host, small = driver.host, driver.page.locator("#small-map")
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (500, {"reason": "no_answer"})
    failed = []
    driver.page.on("console", lambda line: failed.append(line.text))

    def look() -> None:
        driver.state(where=WHERE)
        driver.run_for(500)

    driver.wait_until(lambda: look() or any("map a1" in text for text in failed), "the failure")
    assert not small.is_visible()
    host.replies["GET /maps/a1"] = (200, DETAILS)
    driver.wait_until(lambda: look() or small.is_visible(), "the small map")


def test_the_way_to_a_spot_is_on_the_small_map_before_it_is_gone(driver):
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small = page.locator("#small-map")

    def tell(**news) -> None:
        for _ in range(5):
            driver.state(where=WHERE, **news)
            driver.run_for(500)

    def seen() -> bool:
        tell()
        return small.count() == 1 and small.is_visible()

    wait_until(seen, "the small map")
    page.evaluate("document.body.dataset.view = 'pick'")
    assert small.is_visible()
    picture_came(page)
    tell()
    bare = drawn_on(page)
    goal = {"map": "a1", "x": 4.5, "y": 2.0}
    spot = {"kind": "look", "state": "ready", "goal": goal, "way": [[3.0, 1.0], [4.5, 2.0]]}
    over = {"kind": "look", "name": "x", "state": "arrived", "reason": "", "goal": goal, "mode": ""}
    tell(spot=spot, going=over)
    shown = drawn_on(page)
    assert shown != bare
    tell(spot={**spot, "state": "ended"}, going=over)
    assert drawn_on(page) == bare
    tell(spot={**spot, "goal": {**goal, "map": "b2"}}, going=None)
    assert drawn_on(page) == bare


def test_a_map_that_has_changed_is_shown_as_it_is_now(driver):
    """Drives have updated it, or an update was taken back: its id stays, its version does not."""
    host, page = driver.host, driver.page
    host.pictures["a1"] = PICTURE.png
    host.replies["GET /maps/a1"] = (200, DETAILS)
    small, requested = page.locator("#small-map"), []
    page.on("request", lambda request: requested.append(request.url))

    def tell(where) -> None:
        for _ in range(5):
            driver.state(where=where)
            driver.run_for(500)

    def times() -> int:
        return sum("/maps/a1.png" in url for url in requested)

    wait_until(lambda: tell(WHERE) or (small.count() == 1 and small.is_visible()), "the small map")
    picture_came(page)
    first = drawn_on(page)
    tell(WHERE)
    assert times() == 1
    host.pictures["a1"] = CHANGED.png
    later = {**WHERE, "version": WHERE["version"] + 1}
    wait_until(lambda: tell(later) or drawn_on(page) != first, "the other picture")
    tell(later)
    assert times() == 2
