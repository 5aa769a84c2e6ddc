// Loads parts of the driver's page on demand; reports missing ones.

import { setText } from "./dom.js";
import { retryPause } from "./retry.js";

/** Names of the requested parts that have not loaded yet. */
const missing = new Set();

/** Loads a part, retrying until that succeeds; `more` loads what else it needs. */
export async function fetchPart(name, more) {
  for (;;) {
    try {
      const part = await import(`./${name}.js`);
      await more?.(part);
      missing.delete(name);
      return part;
    } catch (error) {
      console.warn(name, error);
      missing.add(name);
    }
    await retryPause();
  }
}

/** As fetchPart, but tries once, for a press that needs it: null when it does not load. */
const tryPart = (name) => import(`./${name}.js`).catch(() => null);

/** The menu, loaded at its first use. */
export class LateMenu {
  #rest;
  #part = null;

  /** `rest`: arguments of Menu. */
  constructor(...rest) {
    this.#rest = rest;
  }

  /** As Menu.show(); false when the menu did not load. */
  async show(...sheet) {
    const loaded = this.#part ? null : await tryPart("menu");
    if (loaded) this.#part ??= new loaded.Menu(...this.#rest);
    this.#part?.show(...sheet);
    return this.#part !== null;
  }

  act(at) {
    this.#part?.act(at);
  }

  back() {
    this.#part?.back();
  }
}

/** The eye test. `on` receives open(view), lacking() when it does not load, judged(result). */
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
    const loaded = this.#test ? null : await tryPart("eyes");
    if (loaded) this.#test ??= new loaded.EyeTest(left, this.#on.judged);
    if (!this.#test) {
      if (document.body.dataset.view === "eyes") this.#on.open("menu");
      return this.#on.lacking();
    }
    if (document.body.dataset.view === "eyes") this.#test.open(performance.now());
  }

  stop() {
    this.#test?.stop();
  }

  tick(now) {
    this.#test?.tick(now);
  }
}

/** Scanning with one switch, if the profile enables it; `rest`: arguments of SwitchScan. */
export class Scanning {
  #rest;
  #mine;
  #coming = null;
  #part = null;

  constructor(...rest) {
    this.#rest = rest;
  }

  /** Takes a profile. */
  async configure(mine) {
    this.#mine = mine;
    if (mine.scan !== "off") {
      const loaded = await (this.#coming ??= fetchPart("switch_scan"));
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

/** Tiles of plug-in modes, and problems of plug-ins, if there are any. */
export class Plugins {
  /** The PluginTiles, null while there are none. */
  part = null;
  #rest;
  #welcome;
  #coming = null;

  /** `rest`: arguments of PluginTiles. */
  constructor(...rest) {
    this.#rest = rest;
  }

  /** Takes the host's welcome. */
  async update(welcome) {
    this.#welcome = welcome;
    if (!this.part && !welcome.plugins?.length) return;
    const ready = (loaded) => loaded.ready(this.#rest[0]);
    const loaded = await (this.#coming ??= fetchPart("plugin_tiles", ready));
    this.part ??= new loaded.PluginTiles(...this.#rest);
    this.part.update(this.#welcome);
  }

  /** True if not all modes fit next to the directions: their page can be opened. */
  get more() {
    return this.part?.more ?? false;
  }

  /** A problem of a plug-in or this page, if `message` is that all is OK; else `message`. */
  sentence(message, state) {
    if (state) this.part?.rides(state);
    const shown = this.part?.sentence(message, state?.token) ?? message;
    const lacks = missing.size && shown.level === "ok";
    return lacks ? { ...shown, level: "wait", key: "part_missing" } : shown;
  }
}

let late, coming;

/** Shows optional data; the page works without it. */
export function showLate(news, strings) {
  if (news.where || news.assist) coming ??= fetchPart("late", (part) => (late = part));
  late?.show(news, strings);
}
