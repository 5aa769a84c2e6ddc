"""Layout shifts as reported by the browser, including those right after a touch or key."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page

# Every layout-shift entry of the page's life, with what moved, from where, to where.
WATCH = """
window.shifts = [];
const note = (entries) => {
  for (const entry of entries) {
    const what = entry.sources.map(({ node, previousRect: a, currentRect: b }) => {
      const element = node?.nodeType === 1 ? node : node?.parentElement;
      const name = element?.id || element?.className?.baseVal || element?.className ||
        element?.nodeName;
      const place = ({ x, y }) => `${Math.round(x)},${Math.round(y)}`;
      return `${name} ${place(a)} -> ${place(b)}`;
    });
    shifts.push({ value: entry.value, what });
  }
};
const shiftsSeen = new PerformanceObserver((list) => note(list.getEntries()));
shiftsSeen.observe({ type: "layout-shift", buffered: true });
window.takeShifts = () => {
  note(shiftsSeen.takeRecords());
  return shifts.splice(0);
};
"""
# A frame is on the screen when the next begins; the page's own frames follow its stopped clock.
TAKE = """async () => {
  for (let frame = 0; frame < 2; frame++) await new Promise(spied.frame);
  return takeShifts();
}"""


def take(page: Page) -> list[dict[str, Any]]:
    """The shifts since the last call, once the browser has rendered all changes."""
    shifts: list[dict[str, Any]] = page.evaluate(TAKE)
    return shifts
