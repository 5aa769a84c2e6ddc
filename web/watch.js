// Detects what causes no event: sleep, a clock jump, driving left unused.

/** The page stood still, or a clock jumped, by more than this: the tablet slept. */
const JUMP_MS = 1000;

/** Scan times that light every target once, with a margin. */
const SCAN_STEPS = 9;

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
  #limitMs = 15_000;
  #usedMs = 0;

  /** Takes a person's own time; with scanning, at least the time to light every target. */
  configure({ auto_off_s, scan, scan_ms }) {
    this.#limitMs = Math.max(auto_off_s * 1000, scan === "off" ? 0 : SCAN_STEPS * scan_ms);
  }

  /** Driving is used now, or is off. */
  used(now) {
    this.#usedMs = now;
  }

  /** Time left, ms; 0 or less: switch off. */
  leftMs(now) {
    return this.#limitMs - (now - this.#usedMs);
  }
}
