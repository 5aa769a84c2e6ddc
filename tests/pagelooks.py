"""What the pages must look like on any screen, as the browser measures it."""

SCREENS = [(1920, 1080), (1366, 768), (1024, 768)]


def on_every_screen(page, sizes=SCREENS):
    """Each screen's size, the page being shown on it."""
    for width, height in sizes:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("new Promise(spied.frame)")  # the page hears of its size with a frame
        yield width, height


# Share of the screen, on a grid, that is one piece around the middle and under no target.
REST = """
async () => {
  const { HitMap } = await import("/static/hit.js");
  const hits = new HitMap();
  hits.measure(document.querySelectorAll(".target"), 0.2);
  const wide = 96, high = 54, seen = new Set();
  const free = (x, y) => hits.at((x + 0.5) * innerWidth / wide, (y + 0.5) * innerHeight / high,
    null) === null;
  const open = [[wide / 2, 30]];
  while (open.length) {
    const [x, y] = open.pop();
    const key = y * wide + x;
    if (x < 0 || y < 0 || x >= wide || y >= high || seen.has(key) || !free(x, y)) continue;
    seen.add(key);
    open.push([x + 1, y], [x - 1, y], [x, y + 1], [x, y - 1]);
  }
  return seen.size / wide / high;
}
"""
# Every element whose words do not fit into it, or into the target or panel around it.
OVERFLOWING = """
() => [...document.querySelectorAll("button, .panel, #status, .tag, header")].filter(e => {
  const box = e.getBoundingClientRect();
  return box.width && getComputedStyle(e).visibility === "visible" &&
    [...e.querySelectorAll("*")].some(part => {
      const inner = part.getBoundingClientRect();
      return part.textContent.trim() && inner.width && (inner.left < box.left - 1 ||
        inner.right > box.right + 1 || inner.top < box.top - 1 || inner.bottom > box.bottom + 1);
    });
}).map(e => e.id || e.className)
"""
# On the caretaker's page: what is beyond the screen's edge, or is wider than its place.
CUT_OFF = """
() => [...document.querySelectorAll("button, .near, #status, header, #banner, li")].filter(e => {
  const box = e.getBoundingClientRect();
  return box.width && getComputedStyle(e).visibility === "visible" &&
    (box.left < -1 || box.right > innerWidth + 1 || e.scrollWidth > e.clientWidth + 3);
}).map(e => e.id || e.className || e.textContent)
"""
