// What a caretaker draws on a map: places, no-go areas, the home spot; their list and forms.

import { button, element } from "./elements.js";
import { sign } from "./signs.js";
import { sureButton } from "./sure.js";

const TOOLS = ["place", "no_go", "home"];
/** Signs of places, by the host's names for them. */
const ICONS = [
  ...["star", "bed", "sofa", "table", "desk", "kitchen", "toilet", "bath", "tv", "window"],
  ...["door", "garden", "lift", "charger"],
];
const MOST_CORNERS = 24;
const MOST_NAME = 40;

/** A field for a name. */
export const nameField = (texts) => {
  const made = element("input");
  made.maxLength = MOST_NAME;
  made.placeholder = made.ariaLabel = texts.label("maps_name");
  return made;
};

/** `on`: post(request), true when it is done; report(text); changed(). */
export class MapTools {
  #texts;
  #on;
  #tool = "";
  #points = [];
  #buttons = element("p", "buttons");
  #form = element("div", "form");
  #list = element("ul");
  #shown = null;
  root = element("div", "tools");

  constructor(texts, on) {
    this.#texts = texts;
    this.#on = on;
    for (const tool of TOOLS) {
      const one = button(texts.label(`maps_${tool}`), () => this.take(tool));
      one.dataset.tool = tool;
      this.#buttons.append(one);
    }
    this.root.append(this.#buttons, this.#form, this.#list);
  }

  /** The points being tapped. */
  get draft() {
    return { points: this.#points, closed: this.#tool === "no_go" && this.#points.length > 2 };
  }

  /** Switches to another tool, or none; discards a started drawing. */
  take(tool) {
    const was = this.#tool;
    this.#tool = tool === was ? "" : tool;
    this.#points = [];
    if (this.#tool) this.#on.report(this.#texts.label(`maps_${this.#tool}_tap`));
    else if (was) this.#on.report("");
    this.#form.replaceChildren();
    if (this.#tool === "no_go") {
      this.#form.append(this.#strong("maps_done", () => this.#post({ no_go: this.#points })));
    }
    for (const one of this.#buttons.children) one.ariaPressed = one.dataset.tool === this.#tool;
    this.#on.changed();
  }

  /** A tap, in metres. */
  tapped(x, y) {
    if (!this.#tool) return;
    const full = this.#tool === "no_go" ? MOST_CORNERS : 2;
    if (this.#points.length >= full) this.#points.pop();
    this.#points.push([x, y].map((metres) => Math.round(100 * metres) / 100));
    if (this.#tool !== "no_go") {
      const both = this.#points.length === 2;
      this.#on.report(this.#texts.label(both ? "maps_ready" : "maps_heading"));
      if (both && !this.#form.firstChild) this.#spotForm();
    }
    this.#on.changed();
  }

  /** The list of drawn items. */
  show(drawing) {
    if (drawing === this.#shown) return;
    this.#shown = drawing;
    const label = (key, fields) => this.#texts.label(key, fields);
    this.#list.replaceChildren(
      ...(drawing.home ? [this.#row("home", label("maps_home"), { home: null })] : []),
      ...drawing.places.map(({ number, name, icon }) => {
        return this.#row(icon, name, { remove_place: number });
      }),
      ...drawing.no_go.map(({ number }) => {
        return this.#row("no_go", label("maps_area", { n: number }), { remove_no_go: number });
      }),
    );
  }

  #row(icon, text, request) {
    const label = (key) => this.#texts.label(key);
    const act = () => this.#on.post(request);
    const item = element("li");
    const remove = sureButton(label("maps_remove"), label("maps_sure"), act);
    item.append(sign(icon), element("p", "", text), remove);
    return item;
  }

  #strong(key, act) {
    return button(this.#texts.label(key), act, "strong");
  }

  async #post(request) {
    const points = this.#points;
    // Keep a drawing that was started meanwhile.
    if ((await this.#on.post(request)) && points === this.#points) this.take("");
  }

  #spot() {
    const [[x, y], [toX, toY]] = this.#points;
    return { x, y, heading: Math.round((Math.atan2(toY - y, toX - x) * 180) / Math.PI) };
  }

  #spotForm() {
    if (this.#tool === "home") {
      this.#form.append(this.#strong("maps_save", () => this.#post({ home: this.#spot() })));
      return;
    }
    const name = nameField(this.#texts);
    const icon = element("select");
    icon.ariaLabel = this.#texts.label("maps_icon");
    icon.append(...ICONS.map((key) => new Option(this.#texts.label(`maps_${key}`), key)));
    let picture = sign(icon.value);
    icon.addEventListener("change", () => {
      const other = sign(icon.value);
      picture.replaceWith(other);
      picture = other;
    });
    const place = () => ({ name: name.value, icon: icon.value, ...this.#spot() });
    const save = this.#strong("maps_save", () => this.#post({ place: place() }));
    this.#form.append(picture, icon, name, save);
  }
}
