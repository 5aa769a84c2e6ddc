// What stands in the middle while driving is off, and why a wish to drive was not followed.

/** Arming tests the relay (200 ms); a board still disarmed after this has refused. */
const ARMING_MS = 600;
/** Reasons that pass by asking to arm, or by waiting a moment: no reason to hold back. */
const NO_HINDRANCE = ["none", "no_owner", "command_active"];

/** How to begin, or what is still in the way. */
export class Hint {
  #strings;
  #refused;
  #askedMs = null;
  #shown = null;

  /** `refused(key)` is told when the board did not arm. */
  constructor(strings, refused) {
    this.#strings = strings;
    this.#refused = refused;
  }

  /** The driver asked to arm. */
  asked(now) {
    this.#askedMs = now;
  }

  /** The host has answered why not. */
  answered() {
    this.#askedMs = null;
  }

  /** `state` and `armReason` as the host tells them. */
  update(state, armReason, now) {
    this.#show(NO_HINDRANCE.includes(armReason) ? "ready" : armReason);
    if (this.#askedMs === null) return;
    if (state === "armed") this.#askedMs = null;
    if (state !== "disarmed" || now - this.#askedMs < ARMING_MS) return;
    this.#askedMs = null;
    if (armReason !== "none") this.#refused(armReason);
  }

  #show(key) {
    if (key === this.#shown) return;
    this.#shown = key;
    const { text, do: advice } = this.#strings.message(key);
    const title = this.#strings.label(key === "ready" ? "hint_ready" : "hint_waiting");
    document.getElementById("hint-title").textContent = title;
    document.getElementById("hint-text").textContent = text;
    document.getElementById("hint-do").textContent = advice;
  }
}
