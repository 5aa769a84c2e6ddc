"""Layout shifts as reported by the browser, including those right after a touch or key."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page

# Every layout-shift entry of the page's life, with what moved, from where, to where.
WATCH = """
window.shifts = [];
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) {
    const what = entry.sources.map(({ node, previousRect: a, currentRect: b }) => {
      const element = node?.nodeType === 1 ? node : node?.parentElement;
      const name = element?.id || element?.className?.baseVal || element?.className ||
        element?.nodeName;
      const place = ({ x, y }) => `${Math.round(x)},${Math.round(y)}`;
      return `${name} ${place(a)} -> ${place(b)}`;
    });
    shifts.push({ value: entry.value, what });
  }
}).observe({ type: "layout-shift", buffered: true });
"""


def take(page: Page) -> list[dict[str, Any]]:
    """The shifts since the last call, once the browser has rendered all changes."""
    page.wait_for_timeout(60)
    shifts: list[dict[str, Any]] = page.evaluate("shifts.splice(0)")
    return shifts
