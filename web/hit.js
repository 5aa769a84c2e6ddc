// Finds the target at a point: hit areas larger than the buttons, and sticky once entered.

/** Gaze is less exact vertically: hit areas extend by this fraction of the screen's height. */
const VERTICAL_MARGIN = 0.022;

const contains = (box, x, y) => x >= box.left && x < box.right && y >= box.top && y < box.bottom;

/** A box {left, top, right, bottom} (px) grown by `share` of its width and height. */
const grown = (box, share) => {
  const dx = ((box.right - box.left) * share) / 2;
  const dy = ((box.bottom - box.top) * share) / 2;
  return { left: box.left - dx, top: box.top - dy, right: box.right + dx, bottom: box.bottom + dy };
};

/** The hit areas of the page's targets, in CSS px of the viewport. */
export class HitMap {
  #areas = new Map();

  /**
   * Reads the boxes of the given elements (named by id); call again after a resize.
   *
   * `growth` is the share by which a hit area grows, in each dimension, once entered.
   */
  measure(elements, growth) {
    this.#areas.clear();
    for (const element of elements) {
      const { left, top, right, bottom, width } = element.getBoundingClientRect();
      // Not shown, as Achteruit by default.
      if (width === 0) continue;
      const margin = element.classList.contains("drive") ? innerHeight * VERTICAL_MARGIN : 0;
      const area = { left, right, top: top - margin, bottom: bottom + margin };
      this.#areas.set(element.id, { area, sticky: grown(area, growth) });
    }
  }

  /** Whether a target of this name is shown. */
  has(name) {
    return this.#areas.has(name);
  }

  /** Name of the target at (x, y), null for none. `current` keeps its point a little longer. */
  at(x, y, current) {
    const stop = this.#areas.get("stop");
    if (stop && contains(stop.area, x, y)) return "stop";
    const kept = this.#areas.get(current);
    if (kept && contains(kept.sticky, x, y)) return current;
    for (const [name, { area }] of this.#areas) if (contains(area, x, y)) return name;
    return null;
  }
}
