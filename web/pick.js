// Chooses a spot in the picture by a dwell or a tap, and draws its result over the picture.
// Choosing moves nothing: only the tile Ga starts a motion, and only to the shown spot.

import { byId, svg } from "./dom.js";
import { SpotScan } from "./spot_scan.js";
import { button } from "./tile.js";

const VIEW = "pick";
const BACK = "pick-back";
/** A gaze that stays within this fraction of the screen's width rests on one spot. */
const NEAR = 0.045;
/** A dwell ends after this long without a look. */
const STALE_MS = 400;
/** Factor on the dwell for another spot, because the driver first looks at the result. */
const READS = 2;
/** The first dwell enlarges the picture by this factor, which makes the second one more exact. */
const ENLARGED = 3;
/** Looks at these areas do not choose a spot. */
const COVERS = ".target, .panel, #status, header";

function shape(name, parent, fields) {
  const made = svg(name, fields);
  parent.append(made);
  return made;
}

export class Pick {
  /** The tile that starts; its mode is that of the shown spot, "" for none. */
  target = "plugin-go";
  mode = "";
  #strings;
  #texts;
  #on;
  #row = null; // the tile that needs a spot, while the view is open
  #spot = null; // its state from the host
  #going = null;
  #rides = false;
  #dwell = null; // {x, y, count, since, last, done}
  #lens = null; // centre of the enlargement, px
  #go;
  #over; // the drawing over the picture
  #shown = "";
  #bars = new SpotScan();

  /** `on` receives ride("spot", fields), open(view); dwellMs() returns the dwell time. */
  constructor(strings, texts, on) {
    [this.#strings, this.#texts, this.#on] = [strings, texts, on];
    button(BACK, "back", "").querySelector(".label").textContent = strings.label("back");
    this.#go = button(this.target, "forward", "drive plugin");
    this.#over = svg("svg", { id: "over-picture", "aria-hidden": true });
    byId("picture").after(this.#over);
    addEventListener("pointermove", (event) => this.#look(event));
    addEventListener("pointerdown", (event) => this.#tap(event));
    addEventListener("resize", () => {
      this.#enlarge(null);
      this.#bars.show(this.#scanned());
    });
  }

  /** `row`: the tile's row. */
  open(row) {
    this.#row = row;
    this.#dwell = null;
    this.#say(null);
    this.#on.open(VIEW);
  }

  act(name) {
    if (name === BACK && this.#row) {
      this.#say(null);
      return this.#close();
    }
    const spot = this.#bars.choose(name);
    if (spot) this.#choose(...spot);
  }

  /** Takes the host's state, the mode that drives and the ended one; true: `mode` changed. */
  update({ spot, going, state, you }, rides, over, texts) {
    if (state !== "armed" || !you) this.#close();
    const mine = this.#row && spot?.tile === this.#row.name;
    this.#spot = mine ? spot : null;
    this.#going = going ?? null;
    if (performance.now() - this.#dwell?.last > STALE_MS) this.#dwell = null; // drawn no more
    const before = this.mode;
    this.mode = this.#spot?.mode ?? "";
    this.#rides = rides !== "";
    if (!this.#offers) this.#enlarge(null);
    document.body.dataset.spot = this.#rides ? "rides" : (this.#spot?.state ?? "");
    const pauses = this.#rides && rides === this.mode;
    const again = this.mode && over === this.mode;
    const label = this.#texts.asks(pauses, again, texts);
    this.#go.querySelector(".label").textContent = label || this.#texts.label("spot_go");
    this.#go.classList.toggle("unable", !this.mode);
    this.#go.ariaDisabled = !this.mode;
    this.#draw();
    this.#bars.show(this.#scanned());
    return before !== this.mode;
  }

  /** What to do while a spot is chosen, if the sentence `message` is that all is OK; else null. */
  sentence(message) {
    if (!this.#row || this.#rides || message.level !== "ok") return null;
    const spot = this.#spot;
    const empty = !spot || (spot.state === "ended" && !spot.reason);
    const mine = this.#going?.mode?.startsWith(this.#row.name);
    if (empty && mine && !this.#lens) return null; // show how the ride has ended
    const kind = document.body.dataset.scans === "true" ? "scan" : this.#row.of;
    const asks = this.#lens ? "again" : empty ? "look" : "";
    const texts = this.#texts.spot(asks ? { kind, state: asks } : spot);
    const level = !asks && spot.state === "ended" && spot.reason ? "warning" : "ok";
    return { ...message, level, key: "spot", texts };
  }

  /** The chosen spot for the tile, fractions of the picture; null: none. */
  #say(at) {
    this.#on.ride("spot", { tile: this.#row.name, at });
  }

  #close() {
    if (!this.#row) return;
    this.#row = this.#dwell = null;
    this.#enlarge(null);
    this.#bars.show(null);
    this.#on.open("drive");
  }

  /** The picture's rectangle: it covers the screen. */
  #box() {
    const wide = innerWidth / innerHeight > this.#row.aspect;
    const width = wide ? innerWidth : innerHeight * this.#row.aspect;
    const height = wide ? innerWidth / this.#row.aspect : innerHeight;
    return { left: (innerWidth - width) / 2, top: (innerHeight - height) / 2, width, height };
  }

  /** True if spots can be chosen. */
  get #offers() {
    return this.#row && !this.#rides && document.body.dataset.picture !== "stale";
  }

  /** True if a spot can be chosen there: nothing covers it. */
  #free({ target }) {
    return this.#offers && !target.closest?.(COVERS);
  }

  /** The area for scanning: the part of the screen that shows floor within reach. */
  #scanned() {
    if (!this.#offers || document.body.dataset.scans !== "true") return null;
    const box = this.#box();
    const top = Math.max(0, box.top + box.height * (this.#row.top ?? 0));
    return { left: 0, top, width: innerWidth, height: innerHeight - top };
  }

  #look(event) {
    if (event.defaultPrevented || event.buttons !== 0) return;
    if (!this.#free(event)) {
      if (event.target.closest?.(".target")) this.#enlarge(null);
      return this.#rest(null);
    }
    const { clientX: x, clientY: y } = event;
    const at = Math.min(event.timeStamp, performance.now());
    const dwell = this.#dwell;
    const left = !dwell || Math.hypot(x - dwell.x, y - dwell.y) > NEAR * innerWidth;
    if (left || at - dwell.last > STALE_MS) {
      return this.#rest({ x, y, count: 1, since: at, last: at, done: false });
    }
    dwell.count += 1;
    dwell.x += (x - dwell.x) / dwell.count;
    dwell.y += (y - dwell.y) / dwell.count;
    dwell.last = at;
    if (dwell.done || at - dwell.since < this.#dwellMs()) return;
    if (!this.#lens && document.body.dataset.scans !== "true") {
      this.#enlarge(dwell);
      return this.#rest(null);
    }
    dwell.done = true;
    this.#choose(dwell.x, dwell.y);
  }

  /** Enlarges around a spot of the screen, which stays in place; null: the whole picture. */
  #enlarge(at) {
    if (at === this.#lens) return;
    this.#lens = at && { x: at.x, y: at.y };
    const { style } = byId("picture");
    style.transformOrigin = at ? `${at.x}px ${at.y}px` : "";
    style.transform = at ? `scale(${ENLARGED})` : "";
    this.#draw();
  }

  /** Screen position of a spot of the whole picture; `times` 1 / ENLARGED: the inverse. */
  #through([x, y], times = ENLARGED) {
    const lens = this.#lens;
    return lens ? [lens.x + (x - lens.x) * times, lens.y + (y - lens.y) * times] : [x, y];
  }

  #tap(event) {
    if (event.button !== 0 || event.defaultPrevented || !this.#free(event)) return;
    this.#rest(null);
    this.#choose(event.clientX, event.clientY);
  }

  #dwellMs() {
    return this.#on.dwellMs() * (this.mode && !this.#lens ? READS : 1);
  }

  #rest(dwell) {
    if (dwell === null && this.#dwell === null) return;
    this.#dwell = dwell;
    this.#draw();
  }

  #choose(...seen) {
    const [x, y] = this.#through(seen, 1 / ENLARGED);
    this.#enlarge(null);
    const { left, top, width, height } = this.#box();
    const share = (value) => Math.min(1, Math.max(0, Number(value.toFixed(4))));
    const at = [share((x - left) / width), share((y - top) / height)];
    this.#say(at);
    this.#draw();
  }

  /** Draws the path, the spot and the ring of a dwell over the picture. */
  #draw() {
    const way = this.#rides ? this.#going?.px : this.#spot?.px;
    const at = this.#rides ? null : this.#spot?.at;
    const ring = this.#dwell?.done === false ? this.#dwell.since : 0;
    const shown = this.#row ? JSON.stringify([way, at, ring, this.#lens, innerWidth]) : "";
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#over.replaceChildren();
    if (!this.#row) return;
    const { left, top, width, height } = this.#box();
    const place = ([u, v]) => {
      return this.#through([left + u * width, top + v * height]).map(Math.round);
    };
    const points = (way ?? []).map(place).join(" ");
    for (const kind of way?.length ? ["rim", "way"] : []) {
      shape("polyline", this.#over, { points, class: kind });
    }
    if (at) {
      const [cx, cy] = place(at);
      shape("circle", this.#over, { cx, cy, r: innerWidth / 120, class: "spot" });
    }
    if (ring) {
      const dwelling = shape("g", this.#over, { class: "dwelling" });
      dwelling.style.setProperty("--dwell", `${this.#dwellMs()}ms`);
      const { x: cx, y: cy } = this.#dwell;
      shape("circle", dwelling, { cx, cy, r: innerWidth / 40, pathLength: 100, class: "ring" });
    }
  }
}
