// The camera picture: decode off the main thread, draw, acknowledge, mark what is old.

import { Wire } from "./wire.js";

const HEADER_BYTES = 8; // u32 LE sequence, u32 LE age in ms when sent
const STALE_MS = 500;
const SILENCE_MS = 5000;

/**
 * Draws the newest picture on `canvas`.
 *
 * `onAge(state)` is told "fresh", "stale" (older than 500 ms) or "none" (never one seen).
 * The host sends the next picture after the acknowledgement: one in flight, never a queue.
 */
export class Picture {
  #canvas;
  #surface;
  #onAge;
  #wire;
  #bornMs = null; // when the picture shown was taken, on this page's clock
  #state = "none";

  constructor(canvas, onAge) {
    this.#canvas = canvas;
    this.#surface = canvas.getContext("bitmaprenderer");
    this.#onAge = onAge;
    this.#wire = new Wire("/ws/video", SILENCE_MS, { message: (data) => this.#receive(data) });
  }

  /** Age of the picture shown, ms; null before the first. */
  ageMs(now) {
    return this.#bornMs === null ? null : now - this.#bornMs;
  }

  tick(now) {
    this.#wire.tick(now);
    if (this.#bornMs === null) return;
    const state = now - this.#bornMs > STALE_MS ? "stale" : "fresh";
    if (state === this.#state) return;
    this.#state = state;
    this.#onAge(state);
  }

  async #receive(data) {
    const header = new DataView(data, 0, HEADER_BYTES);
    const sequence = header.getUint32(0, true);
    const bornMs = performance.now() - header.getUint32(4, true);
    try {
      await this.#draw(new Uint8Array(data, HEADER_BYTES));
      this.#bornMs = bornMs;
    } catch (error) {
      console.warn(`picture ${sequence} is not a readable JPEG: ${error.message}`);
    }
    this.#wire.send(String(sequence)); // a bad picture too, or the next one would never come
  }

  async #draw(jpeg) {
    const bitmap = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
    if (this.#canvas.width !== bitmap.width) this.#canvas.width = bitmap.width;
    if (this.#canvas.height !== bitmap.height) this.#canvas.height = bitmap.height;
    this.#surface.transferFromImageBitmap(bitmap);
  }
}
