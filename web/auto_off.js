// Counts how long driving is left unused, until it is to go off by itself.

/** The last seconds before driving goes off by itself are counted down. */
const COUNTDOWN_S = 5;

/** The time that driving is left unused. Times in ms. */
export class AutoOff {
  // Of the driver's profile.
  #limitMs;
  #usedMs = 0;
  #scanMs = 0;

  /** Takes a person's own time. */
  configure({ auto_off_s }) {
    this.#limitMs = auto_off_s * 1000;
  }

  /** Driving is used now, or is off. */
  used(now) {
    this.#usedMs = now;
    this.#scanMs = 0;
  }

  /** Scanning needs this long for a choice: driving stays on at least as long. */
  scans(ms) {
    this.#scanMs = Math.max(this.#scanMs, ms);
  }

  /** Time left, ms; 0 or less: switch off. */
  leftMs(now) {
    return Math.max(this.#limitMs, this.#scanMs) - (now - this.#usedMs);
  }

  /** The last seconds, to be shown; 0 before them. */
  countdown(now) {
    const left = Math.ceil(this.leftMs(now) / 1000);
    return left <= COUNTDOWN_S ? left : 0;
  }
}
