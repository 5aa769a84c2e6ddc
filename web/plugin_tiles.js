// Tiles of plug-in modes on the driver's page: held like a direction.

import { AutoMotion } from "./auto_motion.js";
import { byId, setData, svg } from "./dom.js";
import { ARRIVED, goingTexts } from "./going.js";
import { Pick } from "./pick.js";
import { pluginTexts } from "./plugins.js";
import { outline } from "./signs.js";
import { button, styled } from "./tile.js";

/** Places on the page of modes: those of Vooruit, Links and Rechts; place 0 is Achteruit's. */
const PLACES = 3;
/** Rows that have a tile; a "spot" is not a mode: its tile opens the choice of one. */
const KINDS = ["mode", "place", "spot"];
/** Height of an icon's characters, with a box of 100, by their number. */
const SIZES = [60, 60, 40, 28, 22];
/** A sign has this place in that box. */
const SIGN = { class: "sign", transform: "translate(18 18) scale(2.67)" };
const STYLES = ["/static/plugin_tiles.css", "/static/pick.css"];

let texts = null;
let going = null; // texts, too

/** Loads what the tiles need; throws when it does not load. */
export async function ready(strings) {
  texts = await pluginTexts(strings.language);
  going = await goingTexts(strings);
  await Promise.all(STYLES.map(styled));
}

/**
 * The tiles. The first mode of the configuration has Achteruit's place, if that is free; when there
 * is no room for all, a separate page shows them, three at a time.
 *
 * `on` receives shown() when other tiles are shown, replaced() before a place gets another mode,
 * unable(names) for the tiles whose mode does not work now, gone() when that page has no modes;
 * ride("watch") while somebody watches an auto motion, ride("stop") when anything else
 * is pressed, ride("mode", fields) for a mode that is held, ride("spot", fields) for a spot of the
 * picture; tone(shape), open(view), dwellMs().
 */
export class PluginTiles {
  /** True if there is a page of modes. */
  more = false;
  #on;
  #rows = []; // all plug-ins, from the host
  #able = []; // names of the modes that can be held
  #from = 0; // the first mode of the page that is open
  #backward = false;
  #tiles = [];
  #modes = []; // the mode of each place, undefined: none
  #filled = []; // their rows
  #auto = []; // names of the auto modes
  #ride;
  #going = null; // its state from the host
  #pick;
  #edge = 0; // of the newest press
  #paused = 0; // the press that paused it: the rest of its hold starts nothing

  constructor(strings, on) {
    this.#on = on;
    this.#ride = new AutoMotion(() => on.ride("watch"));
    for (let place = 0; place <= PLACES; place += 1) {
      const tile = button(`plugin-${place}`, "forward", "drive plugin");
      tile.querySelector(".arrow").replaceWith(svg("path", SIGN), svg("text", { x: 50, y: 50 }));
      this.#tiles.push(tile);
    }
    this.#pick = new Pick(strings, going, on);
    button("next", "mode", "").querySelector(".label").textContent = texts.label("plugin_next");
    // A new element has no previous place, so it causes no layout shift.
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
    this.#auto = modes.filter(({ auto }) => auto).map(({ mode }) => mode);
    this.#backward = backward;
    this.#show();
  }

  mode(target) {
    if (target === this.#pick.target) return this.#pick.mode;
    return this.#modes[this.#tiles.findIndex((tile) => tile.id === target)];
  }

  /** True if it starts an auto motion. */
  auto(target) {
    return this.#auto.includes(this.mode(target));
  }

  /** True if it opens the choice of a spot. */
  picks(target) {
    return this.#spot(this.mode(target)) !== undefined;
  }

  /** A mode is held, with this press; on the tile of the ride a new press is a pause. */
  use(mode, edge) {
    const spot = this.#spot(mode);
    if (spot) {
      // Not within the press, because it ends what is held.
      if (edge > this.#edge) queueMicrotask(() => this.#pick.open(spot));
      this.#edge = edge;
      return;
    }
    const again = mode === this.#ride.mode && edge > this.#edge;
    if (again) this.#paused = edge;
    this.#edge = edge;
    if (again) this.#on.ride("stop");
    else if (edge !== this.#paused) this.#on.ride("mode", { mode, edge });
  }

  /** Something that does not drive was pressed: that ends a ride. */
  act(name) {
    if (this.#ride.mode) this.#on.ride("stop");
    if (name === "next") {
      this.#from += PLACES;
      this.#show();
    }
    this.#pick.act(name);
  }

  /** Takes the host's state of an auto motion, and of a chosen spot. */
  rides(state) {
    const { auto, going: news } = state;
    const before = this.#going;
    this.#going = news ?? null;
    setData("going", news?.state ?? "");
    setData("why", news?.reason ?? "");
    const arrived = news?.state === "arrived" && before && before.state !== "arrived";
    if (arrived) this.#on.tone(ARRIVED);
    const farther = news?.left_m !== before?.left_m;
    if (this.#ride.update(auto ?? ["", ""]) || farther) this.#fillAll();
    const { mode, over } = this.#ride;
    if (this.#pick.update(state, mode, over, texts)) this.#reportUnable();
  }

  sentence(message, token) {
    const shown = texts.sentence(message, this.#rows, token);
    return this.#pick.sentence(shown) ?? going.sentence(shown, this.#going);
  }

  #spot(mode) {
    return this.#rows.find(({ kind, name }) => kind === "spot" && name === mode);
  }

  #works({ kind, name, state }) {
    return kind === "spot" ? state === "ok" : this.#able.includes(name);
  }

  #reportUnable() {
    const unable = this.#filled.map((row) => row !== undefined && !this.#works(row));
    const names = this.#tiles.filter((_, place) => unable[place]).map(({ id }) => id);
    if (!this.#able.includes(this.#pick.mode)) names.push(this.#pick.target);
    this.#on.unable(names);
  }

  #show() {
    const rows = this.#rows.filter(({ kind }) => KINDS.includes(kind));
    if (this.#from >= rows.length) this.#from = 0;
    // The tile that is always visible is for a mode: a place is only one of many.
    const first = rows[0]?.kind === "mode" ? rows[0] : undefined;
    const places = [this.#backward ? undefined : first];
    for (let at = 0; at < PLACES; at += 1) places.push(rows[this.#from + at]);
    const modes = places.map((row) => row?.name);
    if (modes.some((mode, place) => mode !== this.#modes[place])) this.#on.replaced();
    this.#modes = modes;
    this.more = rows.length > (places[0] ? 1 : 0);
    setData("more", this.more);
    setData("plugin", places[0] !== undefined);
    setData("pages", rows.length > PLACES);
    const pages = Math.ceil(rows.length / PLACES);
    byId("next").querySelector(".small").textContent = `${this.#from / PLACES + 1} / ${pages}`;
    this.#filled = places;
    this.#fillAll();
    this.#reportUnable();
    if (!this.more) this.#on.gone();
    this.#on.shown();
  }

  #fillAll() {
    this.#filled.forEach((row, place) => this.#fill(this.#tiles[place], row));
  }

  #fill(tile, row) {
    tile.hidden = row === undefined;
    if (!row) return;
    const able = this.#works(row);
    const sign = outline(row.sign);
    const icon = sign ? "" : texts.icon(row) || "●";
    tile.querySelector(".sign").setAttribute("d", sign);
    const shape = tile.querySelector("text");
    shape.textContent = icon;
    shape.setAttribute("font-size", SIZES[[...icon].length]);
    const { mode, over } = this.#ride;
    const [rides, again] = [mode === row.name, over === row.name];
    const asks = going.asks(rides, again, texts);
    tile.querySelector(".label").textContent = asks || texts.name(row);
    const left = this.#going?.mode === row.name ? going.left(this.#going) : "";
    const small = rides ? left || texts.label("plugin_rides") : again && texts.name(row);
    tile.querySelector(".small").textContent = small || texts.wrong(row);
    tile.classList.toggle("unable", !able);
    tile.ariaDisabled = !able;
  }
}
