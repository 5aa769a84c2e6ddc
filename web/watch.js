// Detects what causes no event: sleep, a clock jump, driving left unused.

/** The page stood still, or a clock jumped, by more than this: the tablet slept. */
const JUMP_MS = 1000;

/** The last seconds before driving goes off by itself are counted down. */
const COUNTDOWN_S = 5;

/** Detects gaps in the page's time, by its own clock and by the time of day. */
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

/** Switches off unused driving. */
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
