// Parts of the driver's page that are fetched when they are wanted: the eye test, scanning.

import { setText } from "./dom.js";

const RETRY_MS = 2000;

/** The eye test. `on` receives open(view), and judged(result) when it is over. */
export class Eyes {
  #strings;
  #on;
  #test = null;

  constructor(strings, on) {
    this.#strings = strings;
    this.#on = on;
  }

  async begin() {
    this.#on.open("eyes");
    const begins = this.#strings.label("eyes_begin");
    const left = (s) => setText("eyes-left", s === null ? begins : `${s} s`);
    const loaded = await import("./eyes.js").catch(() => null);
    if (!loaded) return this.#on.open("menu");
    this.#test ??= new loaded.EyeTest(left, this.#on.judged);
    if (document.body.dataset.view === "eyes") this.#test.open(performance.now());
  }

  stop() {
    this.#test?.stop();
  }

  tick(now) {
    this.#test?.tick(now);
  }
}

/** Scanning with one switch, while the profile says so; `rest`: what SwitchScan is made of. */
export class Scanning {
  #rest;
  #mine;
  #part = null;

  constructor(...rest) {
    this.#rest = rest;
  }

  /** Takes a profile, trying again until the host has answered. */
  async configure(mine) {
    this.#mine = mine;
    if (mine.scan !== "off") {
      const loaded = await import("./switch_scan.js").catch(() => null);
      if (!loaded) return setTimeout(() => this.configure(this.#mine), RETRY_MS);
      this.#part ??= new loaded.SwitchScan(...this.#rest);
    }
    this.#part?.configure(this.#mine, performance.now());
  }

  cancel(now) {
    this.#part?.cancel(now);
  }

  tick(now) {
    this.#part?.tick(now);
  }
}
