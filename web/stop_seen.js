// Shows whether a STOP is confirmed: sent at once, confirmed when the board reports no request.

/** A stop that the board has not followed for this long is shown as not confirmed. */
const LATE_MS = 1000;
/** How long "seen" stays. */
const SEEN_MS = 3000;

/** The state of the button: "none", "asked", "seen" or "late", on its data-seen. */
export class StopSeen {
  #strings;
  #button = document.getElementById("stop");
  #words = document.getElementById("stop-seen");
  #count = 0; // number of the stop in question; Infinity: nobody will confirm it
  #sinceMs = 0;
  #state = "none";

  constructor(strings) {
    this.#strings = strings;
  }

  /** Somebody pressed Stop; `count`: how many stops this connection has sent, null: not sent. */
  asked(count, now) {
    this.#count = count ?? Infinity;
    this.#sinceMs = now;
    this.#show("asked");
  }

  /** `seen`: how many of them the board has followed. */
  update(seen, now) {
    if (!["asked", "late"].includes(this.#state) || !(seen >= this.#count)) return;
    this.#sinceMs = now;
    this.#show("seen");
  }

  /** The connection has ended: the next one counts its own stops. */
  closed() {
    this.#count = Infinity;
  }

  tick(now) {
    const passed = now - this.#sinceMs;
    if (this.#state === "asked" && passed > LATE_MS) this.#show("late");
    if (this.#state === "seen" && passed > SEEN_MS) this.#show("none");
  }

  #show(state) {
    if (state === this.#state) return;
    this.#button.dataset.seen = this.#state = state;
    this.#words.textContent = state === "none" ? "" : this.#strings.label(`stop_${state}`);
  }
}
