// The status bar: who drives, the request, the chair's motion, the age of link and picture.

import { setText } from "./dom.js";

const AGE_EVERY_MS = 1000;
/** An output nearer to neutral moves nothing. */
const REST_PERMILLE = 36;
const TURN_WINDOW_MS = 400;
/** What this page asks, beside the words for what the chair does. */
const ARROWS = { forward: "↑", backward: "↓", left: "←", right: "→" };

/** Shows the facts; tiny changes only. */
export class Facts {
  #strings;
  #names;
  #headings = []; // [ms, degrees]
  #worst = { link: 0, picture: 0 };
  #shownMs = 0;

  /** `names`: labels to use in place of others. */
  constructor(strings, names = {}) {
    this.#strings = strings;
    this.#names = names;
  }

  /** `news`: the host's state; `asked`: the verb this page commands, null for none. */
  update(news, asked, now) {
    const label = (key) => this.#strings.label(key);
    const owner = `owner_${news.owner}`;
    setText("owner", label(news.you ? "you" : (this.#names[owner] ?? owner)));
    setText("asked", ARROWS[asked] ?? "");
    setText("motion", `${label(`motion_${news.motion}`)}${this.#estimate(news, now)}`);
    const moving = this.#moving(news);
    if (document.body.dataset.moving !== moving) document.body.dataset.moving = moving;
  }

  /** The worst ages of the last second: numbers that can be read. null: not known. */
  ages(linkMs, pictureMs, now) {
    this.#worst.link = Math.max(this.#worst.link, linkMs ?? 0);
    this.#worst.picture = Math.max(this.#worst.picture, pictureMs ?? 0);
    if (now - this.#shownMs < AGE_EVERY_MS) return;
    const word = (ms) => `${Math.round(ms / 10) * 10} ms`;
    if (linkMs !== null) setText("link-age", word(this.#worst.link));
    setText("picture-ms", pictureMs === null ? "–" : word(this.#worst.picture));
    this.#shownMs = now;
    this.#worst = { link: 0, picture: 0 };
  }

  /** Which way the joystick is pushed: a name of a drive target, or "none". */
  #moving({ motion, output_permille: output }) {
    if (motion === "stopped" || output === null) return "none";
    const [linear, turn] = output;
    if (Math.max(Math.abs(linear), Math.abs(turn)) < REST_PERMILLE) return "none";
    if (Math.abs(turn) > Math.abs(linear)) return turn > 0 ? "left" : "right";
    return linear > 0 ? "forward" : "backward";
  }

  /** Speed has no sensor: the push of the joystick, and for turns what the heading does. */
  #estimate({ motion, output_permille: output, heading_deg: heading }, now) {
    this.#headings = this.#headings.filter(([at]) => now - at < 2 * TURN_WINDOW_MS);
    if (heading !== null) this.#headings.push([now, heading]);
    if (motion === "stopped" || output === null) return "";
    const [from] = this.#headings;
    if (motion === "turn" && heading !== null && now - from[0] >= TURN_WINDOW_MS) {
      const turned = ((heading - from[1] + 540) % 360) - 180;
      const rate = Math.round(turned / ((now - from[0]) / 1000) / 5) * 5;
      return ` ± ${Math.abs(rate)}°/s`;
    }
    const push = Math.max(...output.map(Math.abs)) / 1000;
    return ` ± ${Math.round(push * 20) * 5} %`;
  }
}
