// Tiles of the modes that plug-ins bring, on the driver's page: held as a direction is.

import { byId, setData } from "./dom.js";
import { pluginWords } from "./plugins.js";

/** Places on the page of modes, those of Vooruit, Links and Rechts; place 0 is Achteruit's. */
const PLACES = 3;
/** Height of an icon's characters in its mark of 100, by their number. */
const SIZES = [60, 60, 40, 28, 22];
const STYLE = "/static/plugin_tiles.css";

let words = null;

/** Fetches what the tiles need besides; throws when it does not come. */
export async function ready(strings) {
  words = await pluginWords(strings.language);
  await new Promise((resolve, reject) => {
    const link = document.createElement("link");
    [link.rel, link.href, link.onload] = ["stylesheet", STYLE, resolve];
    link.onerror = () => reject(new Error(`${STYLE} does not come`));
    document.head.append(link);
  });
}

/** A button as the others: its mark with the ring, a label, a small line. */
function button(id, like, kind) {
  const tile = document.createElement("button");
  [tile.type, tile.id, tile.className] = ["button", id, `target ${kind}`];
  const mark = byId(like).querySelector(".mark").cloneNode(true);
  for (const name of ["label", "small"]) {
    const line = document.createElement("span");
    [line.className, line.dir] = [name, "auto"];
    tile.append(line);
  }
  tile.prepend(mark);
  byId("stop").before(tile);
  return tile;
}

/**
 * The tiles. The first mode of the configuration has Achteruit's place, where that is free; all of
 * them are on a page of their own, three at a time, when there is no room for all.
 *
 * `on` receives shown() when other tiles are shown, replaced() before a place means another mode,
 * unable(names) for the tiles whose mode does not work now, gone() when that page has no modes.
 */
export class PluginTiles {
  /** There is a page of modes. */
  more = false;
  #on;
  #rows = []; // all plug-ins, as the host tells them
  #able = []; // names of the modes that can be held
  #from = 0; // the first mode of the page that is open
  #backward = false;
  #tiles = [];
  #modes = []; // the mode of each place, undefined: none

  constructor(strings, on) {
    this.#on = on;
    for (let place = 0; place <= PLACES; place += 1) {
      const tile = button(`plugin-${place}`, "forward", "drive plugin");
      const shape = tile.querySelector(".arrow");
      const icon = document.createElementNS(shape.namespaceURI, "text");
      for (const name of ["x", "y"]) icon.setAttribute(name, 50);
      shape.replaceWith(icon);
      this.#tiles.push(tile);
    }
    button("next", "mode", "").querySelector(".label").textContent = words.label("plugin_next");
    // A new element has no place yet that it could be moved from.
    const choices = byId("mode").querySelector(".words");
    const wider = choices.cloneNode(true);
    const choice = wider.lastElementChild.cloneNode(true);
    [choice.className, choice.textContent] = ["choice more", strings.label("more")];
    wider.append(choice);
    choices.replaceWith(wider);
  }

  /** Takes the host's welcome. */
  update({ plugins, modes, backward }) {
    this.#rows = plugins ?? [];
    this.#able = modes.map(({ mode }) => mode);
    this.#backward = backward;
    this.#show();
  }

  mode(target) {
    return this.#modes[this.#tiles.findIndex((tile) => tile.id === target)];
  }

  next() {
    this.#from += PLACES;
    this.#show();
  }

  sentence(told, token) {
    return words.sentence(told, this.#rows, token);
  }

  #show() {
    const rows = this.#rows.filter(({ kind }) => kind === "mode");
    if (this.#from >= rows.length) this.#from = 0;
    const places = [this.#backward ? undefined : rows[0]];
    for (let at = 0; at < PLACES; at += 1) places.push(rows[this.#from + at]);
    const modes = places.map((row) => row?.name);
    if (modes.some((mode, place) => mode !== this.#modes[place])) this.#on.replaced();
    this.#modes = modes;
    this.more = rows.length > (this.#backward ? 0 : 1);
    setData("more", this.more);
    setData("plugin", places[0] !== undefined);
    setData("pages", rows.length > PLACES);
    const pages = Math.ceil(rows.length / PLACES);
    byId("next").querySelector(".small").textContent = `${this.#from / PLACES + 1} / ${pages}`;
    places.forEach((row, place) => this.#fill(this.#tiles[place], row));
    const unable = (place) => modes[place] && !this.#able.includes(modes[place]);
    this.#on.unable(this.#tiles.map(({ id }) => id).filter((_, place) => unable(place)));
    if (!this.more) this.#on.gone();
    this.#on.shown();
  }

  #fill(tile, row) {
    tile.hidden = row === undefined;
    if (!row) return;
    const able = this.#able.includes(row.name);
    const icon = words.icon(row) || "●";
    const shape = tile.querySelector("text");
    shape.textContent = icon;
    shape.setAttribute("font-size", SIZES[[...icon].length]);
    tile.querySelector(".label").textContent = words.name(row);
    tile.querySelector(".small").textContent = words.wrong(row);
    tile.classList.toggle("unable", !able);
    tile.ariaDisabled = !able;
  }
}
