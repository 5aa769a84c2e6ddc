// An auto motion on the driver's page: supervised by eyes that move on the page.

import { standstill } from "./input.js";

/** Between two messages about it; the board's supervision lasts seconds. */
const WATCH_MS = 250;

export class AutoMotion {
  /** The mode that drives, and the one that was ended before its goal; "" for none. */
  mode = "";
  over = "";
  #sentAt = -Infinity;

  /** `watch()`: somebody looks. */
  constructor(watch) {
    const still = standstill();
    addEventListener("pointermove", (event) => {
      if (event.defaultPrevented || still(event)) return;
      const now = performance.now();
      if (!this.mode || document.hidden || now - this.#sentAt < WATCH_MS) return;
      this.#sentAt = now;
      watch();
    });
  }

  /** Takes the host's state; true when something has changed. */
  update([mode, over]) {
    const changed = mode !== this.mode || over !== this.over;
    [this.mode, this.over] = [mode, over];
    return changed;
  }
}
