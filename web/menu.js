// The menu of large tiles while driving is off: practice, eye test, the person's own settings.

const TILES = 5;
const LOOKS = ["normal", "high", "night"];

/**
 * Shows up to five tiles and "Terug"; each tile is a target like any other.
 *
 * `on` receives changed({field: value}), practice(), eyes(), choose(id), closed(), and
 * shown() when other tiles are shown.
 */
export class Menu {
  #strings;
  #profiles;
  #on;
  #sheet = "main";
  #result = null; // of the eye test
  #tiles = [];

  constructor(strings, profiles, on) {
    this.#strings = strings;
    this.#profiles = profiles;
    this.#on = on;
    const back = document.getElementById("back");
    for (let at = 1; at <= TILES; at += 1) {
      const tile = document.createElement("button");
      tile.className = "target tile";
      tile.id = `tile-${at}`;
      tile.type = "button";
      const mark = back.querySelector("svg").cloneNode(true);
      mark.querySelector(".stroke").remove();
      tile.append(mark, document.createElement("span"), document.createElement("span"));
      [tile.children[1].className, tile.children[2].className] = ["label", "small"];
      back.before(tile);
    }
  }

  /** Opens or refreshes a sheet ("main", "times", "looks"; "eyes" with its result). */
  show(sheet = this.#sheet, result = this.#result) {
    this.#sheet = sheet;
    this.#result = result;
    this.#tiles = this[`_${sheet}`]();
    document.getElementById("sheet-title").textContent = this.#strings.label(`menu_${sheet}`);
    for (let at = 0; at < TILES; at += 1) {
      const element = document.getElementById(`tile-${at + 1}`);
      const [label = "", value = ""] = this.#tiles[at] ?? [];
      element.hidden = label === "";
      element.children[1].textContent = label;
      element.children[2].textContent = value;
    }
    this.#on.shown();
  }

  /** A tile (1..5) was chosen. */
  act(at) {
    this.#tiles[at - 1]?.[2]();
  }

  /** "Terug": to the first sheet, then closes. */
  back() {
    if (this.#sheet !== "main") return this.show("main");
    this.#on.closed();
  }

  _main() {
    const label = (key) => this.#strings.label(key);
    const others = this.#profiles.all;
    const next = others[(others.indexOf(this.#profiles.current) + 1) % others.length];
    return [
      [label("practice"), label("practice_text"), () => this.#on.practice()],
      [label("eyes"), label("eyes_text"), () => this.#on.eyes()],
      [label("menu_times"), label("menu_times_text"), () => this.show("times")],
      [label("menu_looks"), label("menu_looks_text"), () => this.show("looks")],
      [label("person"), this.#profiles.current.name, () => this.#on.choose(next.id)],
    ];
  }

  _times() {
    return [
      this.#number("dwell_ms", -1),
      this.#number("dwell_ms", 1),
      this.#number("leave_grace_ms", -1),
      this.#number("leave_grace_ms", 1),
      this.#choice("mode", (mode) => this.#strings.label(mode)),
    ];
  }

  _looks() {
    return [
      this.#choice("contrast", (look) => this.#strings.label(`look_${look}`), LOOKS),
      this.#choice("language", (language) => language.toUpperCase()),
      this.#flag("mirrored"),
      this.#flag("tones"),
    ];
  }

  /** The eye test's result, its proposal, and the choice to accept it. */
  _eyes() {
    const label = (key) => this.#strings.label(key);
    const seconds = (ms) => `${this.#strings.number(ms / 1000, 2)} s`;
    const again = [label("eyes_again"), label("eyes_text"), () => this.#on.eyes()];
    const fact = (title, value) => [title, value, () => {}];
    if (this.#result === null) return [fact(label("eyes_none"), label("eyes_none_text")), again];
    const { jitter, dropouts, longest_ms: longest, dwell_ms, leave_grace_ms } = this.#result;
    const take = () => {
      this.#on.changed({ dwell_ms, leave_grace_ms });
      this.show("times");
    };
    const dwell = `${label("dwell_ms")} ${seconds(dwell_ms)}`;
    const grace = `${label("leave_grace_ms")} ${seconds(leave_grace_ms)}`;
    return [
      fact(label("eyes_jitter"), `${this.#strings.number(jitter, 1)} %`),
      fact(label("eyes_dropouts"), `${dropouts} (${seconds(longest)})`),
      [label("eyes_take"), `${dwell}, ${grace}`, take],
      again,
    ];
  }

  #tile(field, label, shown, value) {
    return [label, shown, () => this.#on.changed({ [field]: value })];
  }

  /** One step less (-1) or more (1) of a time in ms. */
  #number(field, way) {
    const { low, high, step } = this.#profiles.field(field);
    const now = this.#profiles.current[field];
    const next = Math.min(high, Math.max(low, now + way * step));
    const label = `${this.#strings.label(field)} ${way < 0 ? "−" : "+"}`;
    return this.#tile(field, label, `${this.#strings.number(now / 1000, 2)} s`, next);
  }

  #choice(field, word, choices = this.#profiles.field(field).choices) {
    const now = this.#profiles.current[field];
    const next = choices[(choices.indexOf(now) + 1) % choices.length];
    return this.#tile(field, this.#strings.label(field), word(now), next);
  }

  #flag(field) {
    const now = this.#profiles.current[field];
    const word = this.#strings.label(now ? "yes" : "no");
    return this.#tile(field, this.#strings.label(field), word, !now);
  }
}
