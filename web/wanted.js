// Parts of the driver's page that are fetched when they are wanted; what is missing is told.

import { setText } from "./dom.js";

const RETRY_MS = 2000;
/** Names of the parts that are wanted and that the host has not given yet. */
const missing = new Set();

/** Fetches a part, trying again until that succeeds; `more` fetches what it needs besides. */
async function fetchPart(name, more = () => {}) {
  for (;;) {
    try {
      const part = await import(`./${name}.js`);
      await more(part);
      missing.delete(name);
      return part;
    } catch (error) {
      console.warn(`${name}: ${error.message}`);
      missing.add(name);
    }
    await new Promise((resume) => setTimeout(resume, RETRY_MS));
  }
}

/** As fetchPart, once, for who has just asked for it: null when it does not come. */
const tryPart = (name) => import(`./${name}.js`).catch(() => null);

/** The menu, fetched at its first use. */
export class LateMenu {
  #rest;
  #part = null;

  /** `rest`: what Menu is made of. */
  constructor(...rest) {
    this.#rest = rest;
  }

  /** As Menu.show(); false when the menu did not come. */
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

/** The eye test. `on` receives open(view), lacking() when it does not come, judged(result). */
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
      this.#on.open("menu");
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

/** Scanning with one switch, while the profile says so; `rest`: what SwitchScan is made of. */
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

/** Tiles of the modes that plug-ins bring, and what is wrong with plug-ins, where there are any. */
export class Plugins {
  /** The PluginTiles, null while there are none. */
  part = null;
  #rest;
  #welcome;
  #coming = null;

  /** `rest`: what PluginTiles is made of. */
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

  /** More modes than the page has room for beside the directions: their page can be opened. */
  get more() {
    return this.part?.more ?? false;
  }

  /** The sentence `told`; where that is that all is well, what a plug-in or this page lacks. */
  sentence(told, state) {
    if (state) this.part?.rides(state);
    const said = this.part?.sentence(told, state?.token) ?? told;
    const lacks = missing.size > 0 && said.level === "ok";
    return lacks ? { ...said, level: "wait", key: "part_missing" } : said;
  }
}

let late = null;

/** Shows what is not always told: nothing is missing without it. */
export function showLate(news, strings) {
  if (news.where || news.assist) late ??= tryPart("late");
  late?.then((part) => part?.show(news, strings));
}
