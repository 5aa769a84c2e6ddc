// The status corner: always shows OK, wait, warning or error, in plain language.

import { message } from "./strings.js";

/** The status at the bottom right. */
export class StatusCorner {
  #strings;
  #shown = "";

  constructor(strings) {
    this.#strings = strings;
  }

  /** `level`: "ok", "wait", "warning" or "error"; `key`: the message's string key. */
  update({ level, key }) {
    if (`${level} ${key}` === this.#shown) return;
    this.#shown = `${level} ${key}`;
    const corner = document.getElementById("status");
    corner.dataset.level = level;
    message(corner, this.#strings.label(level), this.#strings.message(key));
  }
}
