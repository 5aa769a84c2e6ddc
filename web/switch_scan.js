// Scanning on the driver's page: the switch's events, what is lit, what may be chosen.

import { setData } from "./dom.js";
import { isDrive, isPlugin } from "./intent_times.js";
import { Scan } from "./scan.js";

const KEYS = { space: " ", enter: "Enter", tab: "Tab", f8: "F8" };
/** Bit of the pointer's button in `buttons`; a finger is the first. */
const BUTTONS = { click: 1, right_click: 2 };
const SOURCE = "switch";
/** In this order they are lit; what is not shown is left out. */
const ROWS = [
  ["plugin-go", "pick-back"],
  ["forward", "left", "right", "backward"],
  ["plugin-0", "plugin-1", "plugin-2", "plugin-3", "next"],
  ["arm", "mode", "menu", "help"],
  ["tile-1", "tile-2", "tile-3"],
  ["tile-4", "tile-5", "back"],
];
/** Bars over the picture (spot_scan.js) per row, after the view's own tiles. */
const BARS = 4;
/** A started step counts as moving for this long, before the board has reported it. */
const STEP_BEGINS_MS = 700;

/**
 * A person's switch (a key or a button) chooses among the page's targets.
 *
 * `on` has moving(), whether the chair moves or this page makes it, and receives used() for
 * every press that counts, and needs(ms), the time needed to choose.
 */
export class SwitchScan {
  #targets;
  #hits;
  #on;
  #scan;
  #key = null;
  #button = 0;
  #gaze = true;
  #off = true;
  #closed = new Set(); // contacts: keys by place, and pointers by number
  #movesUntil = 0;

  constructor(targets, hits, on) {
    this.#targets = targets;
    this.#hits = hits;
    this.#on = on;
    this.#scan = new Scan({
      show: (names) => this.#show(names),
      press: (name) => this.#press(name, performance.now()),
      release: () => targets.release(SOURCE, performance.now()),
      doubt: (open) => targets.doubt(SOURCE, open, performance.now()),
      stop: () => targets.stop(performance.now(), true),
      used: on.used,
    });
    // Before all other listeners: marks the switch's events as handled.
    addEventListener("keydown", (event) => this.#keyed(event, true), true);
    addEventListener("keyup", (event) => this.#keyed(event, false), true);
    for (const kind of ["pointerdown", "pointermove", "pointerup"]) {
      addEventListener(kind, (event) => this.#pointed(event), true);
    }
    addEventListener("pointercancel", () => this.cancel(performance.now()));
  }

  /** Takes the settings of a profile; discards a press that began before. */
  configure(mine, now) {
    this.#off = mine.scan === "off";
    setData("scans", !this.#off);
    this.#key = KEYS[mine.scan_switch];
    this.#button = BUTTONS[mine.scan_switch] ?? 0;
    this.#gaze = mine.scan_gaze;
    this.#closed.clear();
    this.#scan.configure(
      {
        rows: mine.scan === "rows",
        stepMs: mine.scan_ms,
        acceptMs: mine.scan_accept_ms,
        debounceMs: mine.scan_debounce_ms,
        lockoutMs: mine.scan_lockout_ms,
      },
      now,
    );
    this.#show(this.#off ? [] : ["stop"]);
    this.tick(now);
  }

  /** Page hidden, focus or link lost: ends every press. */
  cancel(now) {
    this.#closed.clear();
    this.#scan.cancel(now);
  }

  tick(now) {
    if (this.#off) return;
    this.#look(now);
    this.#scan.tick(now);
    this.#on.needs(this.#scan.roundMs);
  }

  /** What may be chosen now, and whether the chair moves. */
  #look(now) {
    const linked = document.body.dataset.link === "ok";
    const may = (name) => this.#hits.has(name) && (!isDrive(name) || this.#targets.armed);
    const rows = linked ? ROWS.map((row) => row.filter(may)) : [];
    const bars = linked ? [...document.querySelectorAll(".spot-bar")].map(({ id }) => id) : [];
    while (bars.length) rows.push(bars.splice(0, BARS));
    this.#scan.offer(
      rows.filter((row) => row.length),
      now,
    );
    this.#scan.setMoving(this.#on.moving() || now < this.#movesUntil, now);
  }

  #press(name, now) {
    const steps = isDrive(name) && !isPlugin(name) && this.#targets.mode === "step";
    if (steps) this.#movesUntil = now + STEP_BEGINS_MS;
    this.#targets.press(name, SOURCE, now);
    if (!isDrive(name)) this.#targets.release(SOURCE, now);
  }

  #show(names) {
    for (const target of document.querySelectorAll(".target, .spot-bar")) {
      target.classList.toggle("lit", !this.#off && names.includes(target.id));
    }
  }

  #keyed(event, down) {
    if (this.#off) return;
    // By its place: what a key is called changes with other keys.
    if (event.key === this.#key || this.#closed.has(event.code)) {
      event.preventDefault();
      if (!event.repeat) this.#contact(event.code, down, event.timeStamp);
    }
    // macOS reports no release while this key is down.
    if (down && (event.metaKey || event.key === "Meta")) this.cancel(performance.now());
  }

  #pointed(event) {
    if (this.#off) return;
    if (!this.#gaze && event.type === "pointermove" && event.buttons === 0) event.preventDefault();
    const { type, pointerId: id, clientX: x, clientY: y } = event;
    const down = (event.buttons & this.#button) !== 0;
    if (down === this.#closed.has(id)) return;
    // No button went down here now (a drag from elsewhere); or it did on Stop, and means Stop.
    if (down && (event.button < 0 || this.#hits.at(x, y, null) === "stop")) return;
    if (down) document.body.setPointerCapture(id);
    if (type === "pointerdown") event.preventDefault();
    this.#contact(id, down, event.timeStamp);
  }

  /** Two keys, fingers or buttons at once are one contact, open when all of them are. */
  #contact(id, down, stamp) {
    const now = performance.now();
    this.#look(now);
    if (down) this.#closed.add(id);
    else if (!this.#closed.delete(id) || this.#closed.size > 0) return;
    this.#scan[down ? "down" : "up"](Math.min(stamp, now), now);
  }
}
