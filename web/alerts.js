// Alerts the caretaker by sound and vibration, even with the phone in a pocket.

const AGAIN_MS = 4000;
const SHAKE_MS = [300, 120, 300];
/** Silence of the chair for this long raises an alarm. */
const LOST_MS = 2000;

/** Sounds while there is a reason; a reason that was seen stays silent until it is new again. */
export class Alerts {
  #tones;
  #reasons = new Set();
  #seen = new Set();
  #open = new Set(); // alerts that are not acknowledged, except a call
  #againAt = 0;
  #stateMs = null;

  constructor(tones) {
    this.#tones = tones;
    // Touching the page proves that somebody has seen it.
    for (const event of ["pointerdown", "keydown"]) {
      addEventListener(event, () => (this.#seen = new Set(this.#reasons)));
    }
  }

  /** Takes the host's state: a call for help and an error are reasons. */
  update({ call, level, message }, now) {
    this.#stateMs = now;
    const reasons = new Set(this.#open);
    if (call) reasons.add("call");
    if (level === "error") reasons.add(message);
    this.#change(reasons, now);
  }

  /** Takes the host's open alerts; a call already comes with the state. */
  open(alerts, now) {
    const others = alerts.filter(({ kind }) => kind !== "help");
    const closed = [...this.#reasons].filter((reason) => !this.#open.has(reason));
    this.#open = new Set(others.map(({ number, count }) => `alert ${number} ${count}`));
    this.#change(new Set([...closed, ...this.#open]), now);
  }

  /** Advances the time; call it often. */
  tick(now) {
    if (this.#stateMs !== null && now - this.#stateMs > LOST_MS && !this.#reasons.has("lost")) {
      this.#change(new Set([...this.#reasons, "lost"]), now);
    }
    const open = [...this.#reasons].some((reason) => !this.#seen.has(reason));
    if (!open || now < this.#againAt) return;
    this.#againAt = now + AGAIN_MS;
    this.#tones.play("alert");
    navigator.vibrate?.(SHAKE_MS);
  }

  #change(reasons, now) {
    if ([...reasons].some((reason) => !this.#reasons.has(reason))) this.#againAt = now;
    this.#seen = new Set([...this.#seen].filter((reason) => reasons.has(reason)));
    this.#reasons = reasons;
  }
}
