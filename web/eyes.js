// "Test ogen": 20 s of looking at dots; measures jitter and dropouts, suggests dwell and grace.

const DOTS = [
  [0.5, 0.5],
  [0.12, 0.45],
  [0.5, 0.2],
  [0.88, 0.45],
  [0.5, 0.75],
];
const DOT_MS = 4000;
/** The eyes' move to a new dot takes this long and does not count. */
const TRAVEL_MS = 1000;
/** Longer between two samples: the tracker has lost the eyes. */
const DROPOUT_MS = 100;
/** Fewer samples than this can't be judged. */
const ENOUGH = 60;

/** The test begins after a gaze this long, this near (screen heights) to the first dot. */
const BEGIN_MS = 1000;
const NEAR = 0.12;
/** A longer gap between two looks at it: the eyes are elsewhere. */
const AWAY_MS = 300;
/** Nobody has looked for this long: there are no eyes to test. */
const NOBODY_MS = 30_000;

/** This fraction of the looks counts for jitter, so that a glance aside does not. */
const STEADY = 0.9;

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const round50 = (value) => Math.round(value / 50) * 50;
const middle = (values) => values.sort((a, b) => a - b)[values.length >> 1];

/**
 * Evaluates `samples` ([ms, x, y] in screen heights, ms from the start of the test).
 *
 * Returns null for too few, else jitter (rms distance to each dot's median, in % of the screen's
 * height, of the 90 % that are nearest), dropouts (their number), longest_ms, and the proposed
 * dwell_ms and leave_grace_ms:
 * grace outlasts 9 of 10 dropouts; dwell is 500 ms, and 100 ms more for each % of jitter and for
 * each dropout per 2 s. Starting points, to be tuned with the person.
 */
export function judge(samples) {
  const gaps = [];
  const squares = [];
  let seen = 0;
  for (let dot = 0; dot < DOTS.length; dot += 1) {
    const from = dot * DOT_MS + TRAVEL_MS;
    const till = (dot + 1) * DOT_MS;
    const here = samples.filter(([at]) => at >= from && at < till);
    seen += here.length;
    let last = from;
    for (const at of [...here.map((sample) => sample[0]), till]) {
      if (at - last > DROPOUT_MS) gaps.push(at - last);
      last = at;
    }
    if (here.length === 0) continue;
    const x = middle(here.map((sample) => sample[1]));
    const y = middle(here.map((sample) => sample[2]));
    squares.push(...here.map((sample) => (sample[1] - x) ** 2 + (sample[2] - y) ** 2));
  }
  if (seen < ENOUGH) return null;
  gaps.sort((a, b) => a - b);
  const steady = squares.sort((a, b) => a - b).slice(0, Math.ceil(squares.length * STEADY));
  const jitter = 100 * Math.sqrt(steady.reduce((sum, one) => sum + one, 0) / steady.length);
  const usual = gaps[Math.floor(gaps.length * 0.9)] ?? 0;
  return {
    jitter,
    dropouts: gaps.length,
    longest_ms: Math.round(gaps[gaps.length - 1] ?? 0),
    dwell_ms: clamp(round50(500 + 100 * jitter + 10 * gaps.length), 500, 1500),
    leave_grace_ms: clamp(round50(usual + 50), 150, 500),
  };
}

/** Runs the test, from the first look at its dot; its owner calls tick(now). */
export class EyeTest {
  #done;
  #label;
  #openedMs = null; // when shown; waits for a gaze
  #look = null; // {since, last}: at the first dot
  #startMs = null;
  #samples = [];
  #dot = document.getElementById("dot");

  /** `label(seconds)` gets the time left, null before the test; `done(result)`: of judge(). */
  constructor(label, done) {
    this.#label = label;
    this.#done = done;
    addEventListener("pointermove", (event) => {
      const at = Math.min(event.timeStamp, performance.now());
      const [x, y] = [event.clientX / innerHeight, event.clientY / innerHeight];
      if (this.#startMs !== null) this.#samples.push([at - this.#startMs, x, y]);
      else if (this.#openedMs !== null) this.#seek(x, y, at);
    });
  }

  /** Shows the first dot; the gaze on it begins the test. */
  open(now) {
    this.stop();
    this.#openedMs = now;
    this.#samples = [];
    this.#place(0);
    this.#label(null);
  }

  /** Ends without a result. */
  stop() {
    this.#startMs = this.#openedMs = this.#look = null;
  }

  tick(now) {
    if (this.#openedMs !== null && now - this.#openedMs > NOBODY_MS) return this.#end();
    if (this.#startMs === null) return;
    const dot = Math.floor((now - this.#startMs) / DOT_MS);
    if (dot >= DOTS.length) return this.#end();
    this.#place(dot);
    this.#label(Math.ceil((DOTS.length * DOT_MS - (now - this.#startMs)) / 1000));
  }

  #seek(x, y, at) {
    const [dotX, dotY] = DOTS[0];
    const far = Math.hypot(x - (dotX * innerWidth) / innerHeight, y - dotY);
    if (far > NEAR || at - this.#look?.last > AWAY_MS) this.#look = null;
    if (far > NEAR) return;
    this.#look ??= { since: at };
    this.#look.last = at;
    if (at - this.#look.since < BEGIN_MS) return;
    this.stop();
    this.#startMs = at;
  }

  #end() {
    const result = judge(this.#samples);
    this.stop();
    this.#done(result);
  }

  #place(dot) {
    const [x, y] = DOTS[dot];
    this.#dot.style.setProperty("transform", `translate(${100 * x}vw, ${100 * y}vh)`);
  }
}
