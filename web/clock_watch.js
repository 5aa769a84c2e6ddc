// Detects that the page stood still or a clock jumped, which causes no event.

/** The page stood still, or a clock jumped, by more than this: the tablet slept. */
const JUMP_MS = 1000;

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
