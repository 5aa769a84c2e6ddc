// The driver's page's messages: its one sentence, in the corner and in the middle; short notices.

import { Banner } from "./banner.js";
import { setData } from "./dom.js";
import { StatusCorner } from "./status.js";

/** Shows one message at a time. */
export class Told {
  /** The sentence: see sentence.js. */
  now = { kind: "none" };
  #banner;
  #corner;

  constructor(strings, tones) {
    this.#banner = new Banner(strings, tones);
    this.#corner = new StatusCorner(strings);
  }

  /** Shows it; returns whether its kind has changed. */
  say(told, now) {
    const other = told.kind !== this.now.kind;
    this.now = told;
    this.#corner.update(told);
    setData("told", told.kind);
    this.#banner.steady(told.kind, told.words, now);
    return other;
  }

  /** What prevents arming is also the reason of every refusal. */
  notice(title, key) {
    const why = this.now.kind === "hindered" && title === "arm_refused" ? this.now.key : key;
    this.#banner.notice(title, why, performance.now());
  }

  tick(now) {
    this.#banner.tick(now);
  }
}
