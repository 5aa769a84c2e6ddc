// Chooses a spot in the picture with one switch: first a column, then a cell of it.

import { byId } from "./dom.js";

const COLUMNS = 16;
const CELLS = 12;

/** Bars over the picture that scanning lights like targets. */
export class SpotScan {
  #area = null; // {left, top, width, height} px, null: nothing can be chosen
  #column = null; // the chosen column, until one of its cells is chosen
  #over = document.createElement("div");

  constructor() {
    this.#over.ariaHidden = "true";
    document.querySelector("main").prepend(this.#over);
  }

  /** Where a spot can be chosen now, null: nowhere. */
  show(area) {
    if (JSON.stringify(area) === JSON.stringify(this.#area)) return;
    this.#area = area;
    this.#column = null;
    this.#draw();
  }

  /** The bar of that name was chosen: the middle of a cell, px; null: its cells are shown next. */
  choose(name) {
    const at = [...this.#over.children].indexOf(byId(name));
    if (this.#area === null || at < 0) return null;
    const { left, top, width, height } = this.#area;
    const column = this.#column;
    this.#column = column === null ? at : null;
    this.#draw();
    if (column === null) return null;
    return [left + ((column + 0.5) * width) / COLUMNS, top + ((at + 0.5) * height) / CELLS];
  }

  #draw() {
    const [{ left, top, width, height }, column] = [this.#area ?? {}, this.#column];
    const wide = width / COLUMNS;
    const high = height / CELLS;
    const cells = Array.from({ length: CELLS }, (_, n) => {
      return [`cell-${column}-${n}`, left + column * wide, top + n * high, wide, high];
    });
    const columns = Array.from({ length: COLUMNS }, (_, n) => {
      return [`column-${n}`, left + n * wide, top, wide, height];
    });
    const bars = column === null ? columns : cells;
    this.#over.replaceChildren(...(this.#area ? bars : []).map((bar) => this.#bar(...bar)));
  }

  #bar(id, left, top, width, height) {
    const made = document.createElement("i");
    [made.id, made.className] = [id, "spot-bar"];
    for (const [name, px] of Object.entries({ left, top, width, height })) {
      made.style.setProperty(name, `${px}px`);
    }
    return made;
  }
}
