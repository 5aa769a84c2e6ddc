// The age of the camera picture; picture_worker.js draws the picture in its own thread.

const STALE_MS = 500;

/**
 * Lets the newest picture be drawn on `canvas`.
 *
 * `onAge(state)` receives "fresh" or "stale" (older than 500 ms); a browser that can't draw in a
 * worker (no OffscreenCanvas) shows no picture. The host sends the next picture after the
 * acknowledgement: one in flight, never a queue.
 */
export class Picture {
  #onAge;
  /** When the picture shown was taken, on this page's clock. */
  #bornMs = null;
  #state = "none";

  constructor(canvas, onAge) {
    this.#onAge = onAge;
    const surface = canvas.transferControlToOffscreen?.();
    if (!surface) return;
    const worker = new Worker("/static/picture_worker.js", { type: "module" });
    worker.onmessage = (event) => (this.#bornMs = performance.now() - event.data);
    worker.postMessage(surface, [surface]);
  }

  /** Age of the picture shown, ms; null before the first. */
  ageMs(now) {
    return this.#bornMs === null ? null : now - this.#bornMs;
  }

  tick(now) {
    if (this.#bornMs === null) return;
    const state = now - this.#bornMs > STALE_MS ? "stale" : "fresh";
    if (state !== this.#state) this.#onAge((this.#state = state));
  }
}
