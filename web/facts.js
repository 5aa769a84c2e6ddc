// The status bar: who drives, the request, motion and speed, the age of link and picture.

import { setData, setText } from "./dom.js";

const AGE_EVERY_MS = 1000;
/** An output nearer to neutral moves nothing. */
const REST_PERMILLE = 36;
/** What this page requests, next to what the chair does. */
const ARROWS = { forward: "↑", backward: "↓", left: "←", right: "→" };

/** Shows the facts; writes only what changed. */
export class Facts {
  #strings;
  #names;
  #worst = { link: 0, picture: 0 };
  #shownMs = 0;

  /** `names`: labels that replace others. */
  constructor(strings, names = {}) {
    this.#strings = strings;
    this.#names = names;
  }

  /** `news`: the host's state; `verb`: the verb this page commands, null for none. */
  update(news, verb) {
    const label = (key) => this.#strings.label(key);
    const owner = `owner_${news.owner}`;
    setText("owner", label(news.you ? "you" : (this.#names[owner] ?? owner)));
    setText("verb", ARROWS[verb] ?? "");
    setText("motion", `${label(`motion_${news.motion}`)}${this.#speed(news)}`);
    setData("moving", this.#moving(news));
  }

  /** The worst ages of the last second: numbers that can be read. null: not known. */
  ages(linkMs, pictureMs, now) {
    const worst = this.#worst;
    worst.link = Math.max(worst.link, linkMs ?? 0);
    worst.picture = Math.max(worst.picture, pictureMs ?? 0);
    if (now - this.#shownMs < AGE_EVERY_MS) return;
    const word = (ms) => `${Math.round(ms / 10) * 10} ms`;
    if (linkMs !== null) setText("link-age", word(worst.link));
    setText("picture-ms", pictureMs === null ? "–" : word(worst.picture));
    this.#shownMs = now;
    this.#worst = { link: 0, picture: 0 };
  }

  /** The direction of the joystick: a name of a drive target, or "none". */
  #moving({ motion, output_permille: output }) {
    if (motion === "stopped" || output === null) return "none";
    const [linear, turn] = output;
    if (Math.max(Math.abs(linear), Math.abs(turn)) < REST_PERMILLE) return "none";
    if (Math.abs(turn) > Math.abs(linear)) return turn > 0 ? "left" : "right";
    return linear > 0 ? "forward" : "backward";
  }

  /** The speed measured by the lidars; "–": not known. */
  #speed({ motion, speed }) {
    if (motion === "stopped") return "";
    if (!speed) return " –";
    if (motion === "turn") return ` ${Math.round(Math.abs(speed.deg_s) / 5) * 5}°/s`;
    return ` ${this.#strings.number(Math.abs(speed.m_s), 1)} m/s`;
  }
}
