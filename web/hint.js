// The hint in the middle while driving is off, and why a request to drive was refused.

import { message } from "./strings.js";

/** Arming tests the relay (200 ms); a board still disarmed after this has refused. */
const ARMING_MS = 600;

/** How to begin, or what still prevents it. */
export class Hint {
  /** True if the driver chooses by scanning. */
  scans = false;
  #strings;
  #refused;
  #sentMs = null;
  #shown = null;

  /** `refused(key)` is called when the board did not arm. */
  constructor(strings, refused) {
    this.#strings = strings;
    this.#refused = refused;
  }

  /** A request to arm was sent. */
  sent(now) {
    this.#sentMs = now;
  }

  /** True until that is answered. */
  get asks() {
    return this.#sentMs !== null;
  }

  /** The host has refused, with a reason. */
  answered() {
    this.#sentMs = null;
  }

  /** `key`: the sentence; `state` and `armReason`: from the host. */
  update(key, state, armReason, now) {
    this.#show(key === "ready" && this.scans ? "ready_scan" : key);
    if (this.#sentMs === null) return;
    if (state === "armed") this.#sentMs = null;
    if (state !== "disarmed" || now - this.#sentMs < ARMING_MS) return;
    this.#sentMs = null;
    if (armReason !== "none") this.#refused(armReason);
  }

  #show(key) {
    if (key === undefined || key === this.#shown) return;
    this.#shown = key;
    const title = this.#strings.label(key.startsWith("ready") ? "hint_ready" : "hint_waiting");
    message(document.getElementById("hint"), title, this.#strings.message(key));
  }
}
