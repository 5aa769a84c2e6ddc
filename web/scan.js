// Single-switch scanning as a pure state machine: what is lit, what a press means.

/** Fewer choices than this are lit one by one: rows would only add a press. */
const FEW = 4;
/** Rounds without a press: then the scan rests on Stop. */
const ROUNDS = 3;
/** Rounds within a row; then the rows again. */
const ROW_ROUNDS = 2;
/** Time to choose, in steps, at least: a row is lit twice before the rows come again. */
const LEAST_STEPS = 9;
/** Too soon after a change to have seen it: a press counts for what was lit before. */
const UNSEEN_MS = 50;
/** A press that arrives later than this (the page stalled) is ignored. */
const OLD_MS = 300;

const same = (a, b) => a.join(" ") === b.join(" ");

/**
 * Lights the choices one after the other, Stop first; a press of the switch takes what is lit.
 *
 * All times are ms of one monotonic clock, and injected. `on` receives show(names) when other
 * targets are lit, press(name) for a choice, release() when the press of that choice ends,
 * doubt(open) when its contact opens, perhaps only for a bounce, and closes again, stop(), and
 * used() for every press that counts.
 * Time alone lights; only a press chooses. While the chair moves every press is a stop.
 */
export class Scan {
  #on;
  #byRows = true;
  // Of the driver's profile:
  #stepMs;
  #acceptMs;
  #debounceMs;
  #lockoutMs;
  #offered = []; // rows of names, without Stop
  #row = null; // the chosen row
  #lit = ["stop"];
  #before = null; // lit before; null: a press can no longer mean it
  #at = 0; // which of the list is lit
  #since = 0; // when its time began
  #litAt = 0;
  #rounds = 0;
  #moving = false;
  #closed = false; // the contact, without bounces
  #openAt = null; // when it opened; what follows soon is a bounce
  #press = null; // {at, names, taken} of a press that counts, until it ends
  #freeAt = -Infinity; // presses before this do not count

  constructor(on) {
    this.#on = on;
  }

  /** Takes a person's times (ms); `rows` false: always one by one. */
  configure({ rows, stepMs, acceptMs, debounceMs, lockoutMs }, at) {
    this.#byRows = rows;
    this.#stepMs = stepMs;
    this.#acceptMs = acceptMs;
    this.#debounceMs = debounceMs;
    this.#lockoutMs = lockoutMs;
    this.cancel(at);
  }

  /**
   * What can be chosen now besides Stop, row by row. A new offer restarts the scan; a press ends
   * unless it holds a target that is still offered.
   */
  offer(rows, at) {
    if (rows.length === this.#offered.length && rows.every((r, n) => same(r, this.#offered[n]))) {
      return;
    }
    this.#offered = rows;
    const kept = this.#held() && rows.flat().includes(this.#press.names[0]);
    if (!kept) this.#drop();
    this.#restart(at);
  }

  /** The chair moves, or may at any moment. A press not taken yet then stops it. */
  setMoving(moving, at) {
    if (moving === this.#moving) return;
    this.#moving = moving;
    if (moving && this.#press && !this.#press.taken) {
      this.#drop();
      this.#on.stop();
    }
    this.#restart(at);
  }

  /** The contact closed at `at`; `now` is when this is called. */
  down(at, now) {
    if (this.#openAt !== null && at - this.#openAt < this.#debounceMs) {
      this.#openAt = null;
      this.#closed = true;
      if (this.#held()) this.#on.doubt(false);
      return;
    }
    if (this.#openAt !== null) this.#over(this.#openAt);
    const again = this.#closed; // its opening was not reported
    this.#closed = true;
    if (this.#moving) return this.#halt(at);
    if (again) return this.#drop();
    if (at < this.#freeAt || now - at > OLD_MS) return;
    const names = at < this.#litAt + UNSEEN_MS ? this.#before : this.#lit;
    if (names === null || names[0] === "stop") return this.#halt(at);
    this.#press = { at, names, taken: false };
    this.#take(at);
  }

  /** The contact opened. */
  up(at, now) {
    if (now - at <= OLD_MS) this.#take(at);
    this.#openAt = at;
    if (this.#held()) this.#on.doubt(true);
    this.tick(at);
  }

  /** The switch's state is no longer known: focus, page or link lost. */
  cancel(at) {
    this.#drop();
    this.#closed = false;
    this.#openAt = null;
    this.#restart(at);
  }

  /** The time needed to choose, ms: everything is lit, and one more step to press at the last. */
  get roundMs() {
    return Math.max(LEAST_STEPS, this.#list().length + 1) * this.#stepMs;
  }

  /** Advances the time; call it often (every 25 ms). */
  tick(now) {
    if (this.#openAt !== null && now - this.#openAt >= this.#debounceMs) {
      this.#over(this.#openAt);
    }
    if (this.#openAt === null) this.#take(now);
    if (this.#closed || this.#moving || now - this.#since < this.#stepMs) return;
    if (this.#list().length > 1 && this.#rounds < ROUNDS) this.#next(now);
  }

  /** Takes the press that has lasted long enough. */
  #take(now) {
    const press = this.#press;
    if (!press || press.taken || now - press.at < this.#acceptMs) return;
    press.taken = true;
    this.#on.used();
    this.#row = press.names.length > 1 ? press.names : null;
    if (!this.#row) this.#on.press(press.names[0]);
    this.#begin(now);
  }

  #halt(at) {
    this.#drop();
    this.#on.used();
    this.#on.stop();
    this.#restart(at);
  }

  /** The contact has opened for good. */
  #over(at) {
    this.#openAt = null;
    if (!this.#closed) return;
    this.#closed = false;
    this.#freeAt = at + this.#lockoutMs;
    this.#since = at;
    this.#drop();
  }

  /** The present press has chosen a target. */
  #held() {
    return this.#press?.taken && this.#press.names.length === 1;
  }

  /** The present press no longer counts. */
  #drop() {
    const held = this.#held();
    this.#press = null;
    if (held) this.#on.release();
  }

  #restart(at) {
    this.#row = null;
    this.#begin(at);
  }

  #begin(at) {
    this.#at = this.#rounds = 0;
    this.#before = null;
    this.#light(at);
  }

  #next(now) {
    this.#before = this.#lit;
    this.#at += 1;
    if (this.#at === this.#list().length) {
      this.#at = 0;
      this.#rounds += 1;
    }
    if (this.#row && this.#rounds === ROW_ROUNDS) {
      this.#row = null;
      this.#at = this.#rounds = 0;
    }
    this.#light(now);
  }

  #light(at) {
    this.#since = this.#litAt = at;
    const lit = this.#list()[this.#at];
    if (same(lit, this.#lit)) return;
    this.#lit = lit;
    this.#on.show(lit);
  }

  /** The items to light one after the other. */
  #list() {
    if (this.#row) return this.#row.map((name) => [name]);
    if (this.#moving) return [["stop"]];
    const all = this.#offered.flat();
    const byRows = this.#byRows && all.length >= FEW;
    return [["stop"], ...(byRows ? this.#offered : all.map((name) => [name]))];
  }
}
