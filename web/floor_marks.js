// Marks on the floor, tapped in the camera's picture: a tap enlarges it, a drag moves the mark.

import { svg } from "./dom.js";

/** Suggested places for marks: cm ahead of the drive axle's middle, and to the left. */
const PLACES = [
  ...[[120, 30], [120, -30], [180, 50], [180, -50], [250, 70], [250, -70]],
  ...[[200, 0], [300, 0], [150, 0], [150, 60]],
];
const LEAST = 6;
const ENLARGED = 4;
/** Step of an arrow key, as a fraction of the picture. */
const NUDGE = 0.0005;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const CROSS_PX = 14;

/** A mark; `at`: where it is seen, as fractions of the picture. */
const unset = ([ahead, left]) => ({ ahead, aside: Math.abs(left), side: left < 0 ? -1 : 1 });
const within = (share) => Math.min(1, Math.max(0, share));

/** A new element in `parent`; its class is its name. */
const made = (name, parent, text = "") => {
  const element = document.createElement(name);
  [element.className, element.textContent, element.dir] = [name, text, "auto"];
  parent.append(element);
  return element;
};

export class FloorMarks {
  #texts;
  #post;
  #marks = PLACES.map(unset);
  #now = 0; // the mark to place now
  #worst = -1;
  #zoom = 1;
  #status = null; // the fit's result; null: none since a mark changed
  #waits = false; // for the fit
  #row = null; // of GET /first-drive
  #sheet = null; // while it is open
  #view = document.querySelector(".view");
  #home = this.#view.parentNode;
  #parts = {};
  #onPicture = false; // the newest touch was
  #grip = null; // the finger that moves the picture: {id, x, y}, pixels

  /** `post(value)` has the host fit the marks; resolves to a refusal, or undefined. */
  constructor(texts, post) {
    [this.#texts, this.#post] = [texts, post];
    addEventListener("resize", () => this.#draw());
  }

  open() {
    if (this.#sheet || this.#row?.refused || !this.#row?.size) return;
    const sheet = made("section", document.body);
    [sheet.id, sheet.ariaLabel] = ["marking", this.#texts.label("first_camera")];
    this.#sheet = sheet;
    this.#parts = { ...this.#picture(sheet), ...this.#panel(sheet) };
    this.#go(this.#now);
  }

  /** The picture, on which the marks are tapped. */
  #picture(sheet) {
    const floor = made("div", sheet);
    [floor.className, floor.tabIndex, floor.role] = ["floor", 0, "application"];
    floor.ariaLabel = this.#texts.label("first_marks_picture");
    floor.append(this.#view);
    const over = svg("svg", { "aria-hidden": true });
    floor.append(over);
    floor.addEventListener("click", (event) => this.#tap(event));
    floor.addEventListener("pointermove", (event) => this.#drag(event));
    floor.addEventListener("pointerdown", (event) => this.#grasp(event));
    const lifted = ({ pointerId: id }) => id === this.#grip?.id && (this.#grip = null);
    for (const end of ["pointerup", "pointercancel"]) floor.addEventListener(end, lifted);
    floor.addEventListener("keydown", (event) => this.#key(event));
    return { floor, over };
  }

  /** What to do, the mark's place on the floor, and the buttons. */
  #panel(sheet) {
    const panel = made("div", sheet);
    panel.className = "panel";
    const asks = made("p", panel);
    const fields = this.#fields(panel);
    const status = made("p", panel);
    [status.className, status.role] = ["status-text", "status"];
    const controls = made("div", panel);
    controls.className = "controls";
    const button = (key, act, kind = "") => {
      const one = made("button", controls, this.#texts.label(key));
      [one.type, one.className] = ["button", kind];
      one.addEventListener("click", act);
      return one;
    };
    const before = button("first_marks_before", () => this.#go(this.#now - 1));
    const next = button("first_marks_next", () => this.#go(this.#now + 1));
    const whole = button("first_marks_whole", () => this.#enlarge(1));
    const fit = button("first_marks_fit", () => this.#fit(), "strong");
    button("first_marks_close", () => this.close());
    return { asks, ...fields, status, before, next, whole, fit };
  }

  #fields(panel) {
    const label = (key) => this.#texts.label(key);
    const place = made("div", panel);
    place.className = "place";
    const number = (key) => {
      const row = made("label", place, label(key));
      const input = made("input", row);
      [input.type, input.min, input.max, input.inputMode] = ["number", 0, 600, "numeric"];
      input.addEventListener("input", () => input.value && this.#typed()); // none is not 0
      input.addEventListener("change", () => this.#fill());
      return input;
    };
    const [ahead, aside] = [number("first_marks_ahead"), number("first_marks_aside")];
    const side = made("select", place);
    side.ariaLabel = label("first_marks_aside");
    side.append(new Option(label("first_marks_left"), 1));
    side.append(new Option(label("first_marks_right"), -1));
    side.addEventListener("change", () => this.#typed());
    return { ahead, aside, side };
  }

  close() {
    if (!this.#sheet) return;
    this.#view.style.removeProperty("--zoom");
    this.#home.prepend(this.#view);
    this.#sheet.remove();
    this.#sheet = null;
  }

  /** Takes the step's row; what was reported of the newest fit, its `fields`; null: it runs. */
  update(row, status, fields) {
    this.#row = row;
    if (row.refused === "setting_while_armed") {
      // The chair may have moved since: the old marks are invalid.
      for (const mark of this.#marks) delete mark.at;
      [this.#now, this.#worst] = [0, -1];
    }
    if (row.refused) return this.close();
    if (this.#waits && fields) {
      this.#waits = false;
      this.#status = status;
      this.#worst = (fields.mark || 0) - 1;
      this.#go(this.#worst < 0 ? this.#now : this.#worst);
    }
    this.#draw();
  }

  async #fit() {
    if (this.#waits) return;
    const given = this.#marks.filter(({ at }) => at);
    const share = (value) => Number(value.toFixed(4));
    const rows = given.map(({ at, ahead, aside, side }) => {
      return [...at.map(share), ahead, aside * side];
    });
    this.#status = this.#texts.label("first_running");
    this.#draw();
    const refusal = await this.#post(rows);
    this.#waits = !refusal;
    if (refusal) this.#status = refusal;
    this.#draw();
  }

  get #mark() {
    return this.#marks[this.#now];
  }

  /** Asks for the next mark; all before it have their place. */
  #go(to) {
    const first = this.#marks.findIndex(({ at }) => !at);
    const last = first < 0 ? this.#marks.length - 1 : first;
    this.#now = Math.max(0, Math.min(to, last));
    this.#fill();
    this.#enlarge(1);
  }

  #fill() {
    for (const name of this.#sheet ? ["ahead", "aside", "side"] : []) {
      this.#parts[name].value = this.#mark[name];
    }
  }

  #typed() {
    for (const name of ["ahead", "aside", "side"]) {
      this.#mark[name] = Number(this.#parts[name].value);
    }
    this.#changed();
  }

  #changed() {
    this.#status = null;
    this.#waits = false;
    this.#worst = -1;
    this.#draw();
  }

  #put(u, v) {
    this.#mark.at = [within(u), within(v)];
    this.#changed();
  }

  #enlarge(zoom) {
    this.#zoom = zoom;
    this.#draw();
  }

  /** A touch on something over the picture (a banner, a call) does not count. */
  #grasp({ target, pointerId: id, clientX: x, clientY: y }) {
    this.#onPicture = target.id === "picture";
    this.#grip = this.#onPicture ? { id, x, y } : null;
    if (this.#grip) this.#parts.floor.setPointerCapture(id);
  }

  /** On the whole picture: places the mark there and enlarges. */
  #tap({ clientX, clientY }) {
    if (!this.#onPicture || this.#zoom !== 1) return;
    const box = this.#parts.floor.getBoundingClientRect();
    this.#zoom = ENLARGED;
    this.#put((clientX - box.left) / box.width, (clientY - box.top) / box.height);
  }

  /** When enlarged, the picture moves with the newest finger, and the cross stays. */
  #drag({ pointerId: id, buttons, clientX: x, clientY: y }) {
    if (this.#grip?.id !== id || this.#zoom === 1 || buttons === 0) return;
    const [du, dv] = [this.#grip.x - x, this.#grip.y - y];
    this.#grip = { id, x, y };
    const box = this.#parts.floor.getBoundingClientRect();
    this.#move(du / box.width / this.#zoom, dv / box.height / this.#zoom);
  }

  #key(event) {
    const way = KEYS[event.key];
    if (!way) return;
    event.preventDefault();
    this.#zoom = ENLARGED;
    this.#move(way[0] * NUDGE, way[1] * NUDGE);
  }

  #move(du, dv) {
    const [u, v] = this.#mark.at ?? [0.5, 0.5];
    this.#put(u + du, v + dv);
  }

  #draw() {
    if (!this.#sheet) return;
    const { floor, over, asks, status, before, next, whole, fit } = this.#parts;
    const mark = this.#mark;
    const [wide, high] = this.#row.size;
    this.#sheet.style.setProperty("--shape", wide / high);
    // The mark being adjusted is in the middle.
    const zoom = mark.at ? this.#zoom : 1;
    const [left, top] = zoom === 1 ? [0, 0] : mark.at.map((share) => 0.5 - share * zoom);
    const moved = `translate(${100 * left}%, ${100 * top}%) scale(${zoom})`;
    this.#view.style.setProperty("--zoom", moved);
    const label = (key, fields) => this.#texts.label(key, fields);
    const known = this.#marks.filter(({ at }) => at).length;
    const n = this.#now + 1;
    const seen = mark.at ? "first_marks_again" : "first_marks_place";
    asks.textContent = label(zoom > 1 ? "first_marks_fine" : seen, { n });
    const lacks = LEAST - known;
    const enough = label(lacks > 0 ? "first_marks_lacks" : "first_marks_enough", { n: lacks });
    status.textContent = this.#status ?? enough;
    before.disabled = this.#now === 0;
    next.disabled = !mark.at || n === this.#marks.length;
    whole.disabled = zoom === 1;
    fit.disabled = lacks > 0 || this.#waits;
    const box = floor.getBoundingClientRect();
    const px = ([u, v]) => [(left + u * zoom) * box.width, (top + v * zoom) * box.height];
    over.replaceChildren();
    for (const line of this.#row.lines) this.#line(over, line, px);
    for (const [at, one] of this.#marks.entries()) if (one.at) this.#cross(over, at, px(one.at));
  }

  #shape(name, parent, kind, fields) {
    const shape = svg(name, { class: kind, ...fields });
    parent.append(shape);
    return shape;
  }

  #line(over, { m, px }, place) {
    const points = px.map((at) => place(at).map(Math.round));
    this.#shape("polyline", over, "metre", { points: points.join(" ") });
    const [x, y] = points[points.length - 1];
    this.#shape("text", over, "metre", { x, y }).textContent = `${m} m`;
  }

  #cross(over, at, [x, y]) {
    const kind = at === this.#worst ? "cross worst" : at === this.#now ? "cross now" : "cross";
    const arms = `M${x - CROSS_PX} ${y}h${2 * CROSS_PX}M${x} ${y - CROSS_PX}v${2 * CROSS_PX}`;
    for (const edge of ["rim", "ink"]) this.#shape("path", over, `${kind} ${edge}`, { d: arms });
    const beside = { x: x + CROSS_PX / 2, y: y - CROSS_PX / 2 };
    this.#shape("text", over, kind, beside).textContent = at + 1;
  }
}
