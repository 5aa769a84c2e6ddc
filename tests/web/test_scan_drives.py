"""The scanning page's own modules and the whole firmware: the beginning of a benchmark's run."""

import pytest

from gazemeasure import scanning
from gazemeasure.scanning_person import Switcher

pytestmark = [pytest.mark.browser, pytest.mark.long]


def test_two_presses_turn_the_chair(chromium, monkeypatch):
    monkeypatch.setattr(scanning, "_LIMIT_MS", 7_500)
    page = chromium.new_page()
    run = scanning._Run(page, Switcher(0, True), "hold", 0)
    found = run()
    page.close()
    assert (found.passed, found.presses, found.collisions) == (False, 2, 0)
    assert run._chair.world.chair.heading_deg > 5
