// Detects what gives the page no event: sleep, a clock jump, driving left unused.

/** The page stood still, or a clock jumped, by more than this: the tablet slept. */
const JUMP_MS = 1000;

/** Tells of gaps in the page's time, by its own clock and by the time of day. */
export class ClockWatch {
  #last = null; // {now, day}

  /** True when time jumped since the last call. `now`: performance.now(), `day`: Date.now(). */
  jumped(now, day) {
    const last = this.#last;
    this.#last = { now, day };
    if (last === null) return false;
    return now - last.now > JUMP_MS || Math.abs(day - last.day) > JUMP_MS;
  }
}

/** Driving that is on and unused goes off by itself. */
export class AutoOff {
  #limitMs = 15_000;
  #usedMs = 0;

  /** `seconds` of not being used. */
  configure(seconds) {
    this.#limitMs = seconds * 1000;
  }

  /** Driving is used now, or is off. */
  used(now) {
    this.#usedMs = now;
  }

  /** What is left, ms; 0 or less: time to switch off. */
  leftMs(now) {
    return this.#limitMs - (now - this.#usedMs);
  }
}
