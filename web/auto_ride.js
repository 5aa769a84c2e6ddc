// An auto ride on the driver's page: supervised by eyes that move on the page.

/** Between two messages about it; the board's supervision lasts seconds. */
const WATCH_MS = 250;

export class AutoRide {
  /** The mode that drives, and the one that was ended before its goal; "" for none. */
  mode = "";
  over = "";
  #saidAt = -Infinity;
  #last = ""; // where the pointer was

  /** `watch()`: somebody looks. */
  constructor(watch) {
    addEventListener("pointermove", (event) => {
      // The browser repeats a pointer that stands still: that does not prove that anyone looks.
      const place = `${event.clientX} ${event.clientY}`;
      if (event.defaultPrevented || place === this.#last) return;
      this.#last = place;
      const now = performance.now();
      if (!this.mode || document.hidden || now - this.#saidAt < WATCH_MS) return;
      this.#saidAt = now;
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
