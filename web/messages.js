// Shows the messages of the driver's page: one sentence, in the corner and in the middle; notices.

import { Banner } from "./banner.js";
import { setData } from "./dom.js";
import { StatusCorner } from "./status.js";

/** Shows one message at a time. */
export class Messages {
  /** The shown sentence: see sentence.js. */
  now = { kind: "none" };
  #banner;
  #corner;

  constructor(strings, tones) {
    this.#banner = new Banner(strings, tones);
    this.#corner = new StatusCorner(strings);
  }

  /** Shows `message`, a sentence; returns whether its kind has changed. */
  show(message, now) {
    const changed = message.kind !== this.now.kind;
    this.now = message;
    this.#corner.update(message);
    setData("message", message.kind);
    this.#banner.steady(message.kind, message.words, now);
    return changed;
  }

  /** A short notice. What prevents arming is also the reason of every refusal. */
  notice(title, key) {
    const why = this.now.kind === "hindered" && title === "arm_refused" ? this.now.key : key;
    this.#banner.notice(title, why, performance.now());
  }

  tick(now) {
    this.#banner.tick(now);
  }
}
