// Shows whether a STOP is confirmed: sent at once, confirmed when the board reports no request.

import { byId, setText } from "./dom.js";

/** A stop that the board has not followed for this long is shown as not confirmed. */
const LATE_MS = 1000;
/** How long "seen" stays. */
const SEEN_MS = 3000;

/** The state of the button: "none", "sent", "seen" or "late", on its data-seen. */
export class StopSeen {
  #strings;
  /** Number of the stop in question; Infinity: none will be confirmed. */
  #count = Infinity;
  #sinceMs = 0;
  #state = "none";

  constructor(strings) {
    this.#strings = strings;
  }

  /** Somebody pressed Stop; `count`: its number on this connection, false when it was not sent. */
  sent(count, now) {
    this.#count = count || Infinity;
    this.#show("sent", now);
  }

  /** `seen`: how many stops of this connection the board has followed. */
  update(seen, now) {
    if (!(seen >= this.#count)) return;
    this.closed();
    this.#show("seen", now);
  }

  /** The connection has ended: the next one counts its own stops. */
  closed() {
    this.#count = Infinity;
  }

  tick(now) {
    const passed = now - this.#sinceMs;
    if (this.#state === "sent" && passed > LATE_MS) this.#show("late", now);
    if (this.#state === "seen" && passed > SEEN_MS) this.#show("none", now);
  }

  #show(state, now) {
    this.#sinceMs = now;
    byId("stop").dataset.seen = this.#state = state;
    setText("stop-seen", state === "none" ? "" : this.#strings.label(`stop_${state}`));
  }
}
