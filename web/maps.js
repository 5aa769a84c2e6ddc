// Maps on the caretaker's page: make one while driving, draw on it, rename, delete, files.

import { button, element, put } from "./elements.js";
import { MapFiles, download } from "./map_files.js";
import { MapTools, nameField } from "./map_tools.js";
import { MapView } from "./map_view.js";
import { mapTexts } from "./map_texts.js";
import { post } from "./post.js";
import { sureButton, unsure } from "./sure.js";

const POLL_MS = 500;
const PICTURE_MS = 2000;
const NOTHING = { places: [], no_go: [], home: null };

/** True while a map is being made, by the host's answer. */
const makes = (answer) => answer.wants !== "know";

/** Ready to be shown; throws when its texts do not load. */
export async function maps(root, strings) {
  return new Maps(root, await mapTexts(strings));
}

class Maps {
  #texts;
  #view;
  #parts = {};
  #all = null; // the host's newest answer
  #chosen = ""; // map
  #details = null; // of the chosen map
  #planless = false; // its plan did not load
  #tools;
  #files;
  #polledMs = -Infinity;
  #pictureMs = -Infinity;
  #asking = 0; // unanswered requests
  #sent = 0; // requests and files sent
  #rows = "";
  #opened = null; // map
  #loaded = ""; // the row with which the details were requested

  constructor(root, texts) {
    this.#texts = texts;
    const label = (key) => texts.label(key);
    const canvas = element("canvas");
    canvas.setAttribute("role", "img");
    canvas.ariaLabel = label("maps_picture");
    this.#view = new MapView(canvas, (x, y) => this.#details && this.#tools.tapped(x, y));
    this.#tools = new MapTools(texts, {
      post: (request) => this.#post({ map: this.#chosen, ...request }),
      report: (text) => this.#report(text),
      changed: () => this.#arrange(),
    });
    this.#files = new MapFiles(texts, {
      send: (path, request) => this.#send(path, request),
      report: (text) => this.#report(text),
      most: () => this.#all?.most_file_bytes ?? 0,
    });
    const parts = this.#parts;
    parts.choose = element("select");
    parts.choose.ariaLabel = label("maps_choose");
    parts.choose.addEventListener("change", () => this.#open(parts.choose.value));
    parts.make = button(label("maps_make"), () => this.#post({ make: true }), "strong");
    parts.status = element("p", "status-text");
    parts.status.setAttribute("role", "status");
    parts.making = this.#makingForm();
    parts.rename = this.#renameForm();
    const top = element("p", "top");
    top.append(parts.choose, parts.make, this.#files.root);
    root.replaceChildren(top, parts.status, canvas, parts.making, this.#tools.root, parts.rename);
    this.#arrange();
  }

  tick(now) {
    if (this.#asking || now - this.#polledMs < POLL_MS) return;
    this.#polledMs = now;
    const sent = this.#sent;
    this.#ask("/maps", { cache: "no-store" }).then((answer) => {
      // A request made meanwhile gets its own, newer answer.
      if (!answer || sent !== this.#sent) return;
      this.#show(answer, now);
      if (makes(answer)) return;
      // What did not load, or was changed by somebody else.
      if (this.#asking) return;
      if (this.#details ? this.#row !== this.#loaded : this.#usable) this.#load();
      else if (this.#details && this.#planless) this.#plan();
    });
  }

  #makingForm() {
    const label = (key) => this.#texts.label(key);
    const form = element("div", "making");
    const name = nameField(this.#texts);
    const buttons = element("p", "buttons");
    buttons.append(
      button(label("maps_save"), () => this.#post({ save: name.value }), "strong"),
      sureButton(label("maps_discard"), label("maps_sure"), () => this.#post({ discard: true })),
    );
    form.append(element("p", "note", label("maps_how")), name, buttons);
    return form;
  }

  #renameForm() {
    const label = (key) => this.#texts.label(key);
    const form = element("div", "rename");
    const name = nameField(this.#texts);
    this.#parts.name = name;
    const buttons = element("p", "buttons");
    const act = (request) => this.#post({ map: this.#chosen, ...request });
    const sure = label("maps_sure");
    this.#parts.back = sureButton(label("maps_back"), sure, () => act({ back: true }));
    const file = () => download(`/maps/${this.#chosen}.zip`);
    this.#parts.files = button(label("maps_files"), file);
    this.#parts.updated = element("p", "note");
    buttons.append(
      button(label("maps_rename"), () => act({ rename: name.value })),
      sureButton(label("maps_delete"), sure, () => act({ delete: true })),
      this.#parts.files,
      this.#parts.back,
    );
    form.append(name, this.#parts.updated, buttons);
    return form;
  }

  async #ask(path, request) {
    this.#asking += 1;
    try {
      const answer = await fetch(path, request);
      const found = await answer.json();
      if (answer.ok) return found;
      this.#report(this.#texts.reason(found.reason));
    } catch (error) {
      console.warn(`maps: ${error.message}`);
      this.#report(this.#texts.reason("no_answer"));
    } finally {
      this.#asking -= 1;
    }
    return null;
  }

  /** True when the host has done it. */
  async #post(request) {
    this.#report("");
    return this.#send("/maps", post(request));
  }

  async #send(path, request) {
    this.#sent += 1;
    const answer = await this.#ask(path, request);
    if (!answer) return false;
    if (answer.added) this.#choose(answer.added);
    this.#show(answer, performance.now());
    if (answer.added) this.#report(this.#texts.reason("maps_stored"));
    if (this.#chosen) await this.#load();
    return true;
  }

  #report(text) {
    this.#parts.answer = text;
    put(this.#parts.status, text);
  }

  #show(answer, now) {
    const was = this.#all;
    this.#all = answer;
    const making = makes(answer);
    if (this.#parts.answer === this.#texts.reason("no_answer")) this.#report("");
    const ended = answer.ended;
    // What had ended before this page looked on is no news.
    if (was && ended && JSON.stringify(ended) !== JSON.stringify(was.ended)) {
      this.#report(this.#texts.reason(ended.reason || "maps_stored"));
      if (!ended.reason) this.#choose(ended.map);
    }
    const rows = JSON.stringify(answer.maps.map(({ map, name }) => [map, name]));
    if (rows !== this.#rows) this.#list(rows);
    this.#parts.choose.value = this.#chosen;
    if (making) {
      if (was && !makes(was)) this.#view.clear();
      this.#view.chair(answer.making);
      if (now - this.#pictureMs > PICTURE_MS) this.#grow(now);
    } else if (was && makes(was)) this.#open(this.#chosen);
    else this.#view.chair(answer.where?.map === this.#chosen ? answer.where : null);
    this.#sentence();
    if (!was || makes(was) !== making) this.#arrange();
  }

  #list(rows) {
    this.#rows = rows;
    const { maps, where } = this.#all;
    const options = maps.map(({ map, name, problem }) => {
      return new Option(name || this.#texts.label(problem || "maps_choose"), map);
    });
    this.#parts.choose.replaceChildren(...options);
    const there = maps.some(({ map }) => map === this.#chosen);
    const first = where?.map ?? maps[0]?.map ?? "";
    const map = there ? this.#chosen : first;
    if (map !== this.#opened) this.#open(map); // else a started drawing would be lost
  }

  /** The state in one line; the last answer stays until something is done. */
  #sentence() {
    if (this.#parts.answer) return;
    const { state, wants, making, where, maps } = this.#all;
    const label = (key, fields) => this.#texts.label(key, fields);
    const number = (value) => this.#texts.number(value, 0);
    let text = "";
    if (wants === "save") text = label("maps_saving");
    else if (making?.doubt) text = this.#texts.reason(`map_${making.doubt}`);
    else if (wants === "make") {
      const fields = { m: number(making?.driven_m ?? 0), n: number(making?.loops ?? 0) };
      text = label("maps_growing", fields);
    } else if (state === "off") text = this.#texts.reason("map_no_lidar");
    else if (maps.length === 0) text = label("maps_none");
    else if (where) {
      const name = maps.find(({ map }) => map === where.map)?.name ?? "?";
      text = label("maps_here", { name });
    } else text = label("maps_nowhere");
    put(this.#parts.status, text);
  }

  async #grow(now) {
    this.#pictureMs = now;
    const answer = await this.#ask("/maps/growing", { cache: "no-store" });
    if (!answer?.picture || !makes(this.#all)) return;
    this.#view.picture(`/maps/growing.png?${Math.round(now)}`, answer.picture);
  }

  #choose(map) {
    if (map === this.#chosen) return;
    this.#chosen = map;
    this.#parts.name.value = "";
    unsure(this.#parts.rename);
  }

  #open(map) {
    this.#choose(map);
    this.#opened = map;
    this.#details = null;
    this.#tools.take("");
    if (!this.#all || makes(this.#all)) return;
    this.#view.clear();
    this.#load();
  }

  get #usable() {
    const map = this.#chosen;
    return this.#all.maps.some((one) => one.map === map && one.problem !== "map_damaged");
  }

  /** The host's facts on the chosen map that need no request; they change with its details. */
  get #row() {
    return JSON.stringify(this.#all.maps.find(({ map }) => map === this.#chosen));
  }

  async #load() {
    const [map, row] = [this.#chosen, this.#row];
    const details = this.#usable ? await this.#ask(`/maps/${map}`, { cache: "no-store" }) : null;
    if (map !== this.#chosen || makes(this.#all)) return;
    const named = this.#details?.name;
    this.#details = details;
    this.#loaded = row;
    if (!this.#usable) this.#view.clear();
    if (details) {
      if (details.name !== named) this.#parts.name.value = details.name ?? "";
      this.#plan();
    }
    this.#arrange();
  }

  async #plan() {
    const details = this.#details;
    this.#planless = false;
    // Under a URL that the page has shown, it would show the same picture again.
    const url = `/maps/${this.#chosen}.png?${Math.round(performance.now())}`;
    const loaded = await this.#view.picture(url, details.picture);
    this.#planless = !loaded && details === this.#details;
  }

  /** Shows the parts; while a map is being made, only those for that. */
  #arrange() {
    const making = this.#all !== null && makes(this.#all);
    const parts = this.#parts;
    parts.making.hidden = !making;
    parts.make.disabled = parts.choose.disabled = Boolean(making);
    this.#tools.root.hidden = making || !this.#details;
    parts.rename.hidden = making || !this.#chosen;
    parts.files.hidden = !this.#details;
    this.#files.root.disabled = making || !this.#all;
    const updates = this.#details?.updates;
    parts.back.hidden = parts.updated.hidden = !updates;
    const when = this.#texts.moment(this.#details?.updated);
    put(parts.updated, updates ? this.#texts.label("maps_updated", { when }) : "");
    const drawing = (making ? null : this.#details) ?? NOTHING;
    this.#tools.show(drawing);
    this.#view.show(drawing, this.#tools.draft);
  }
}
