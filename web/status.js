// The status corner: always shows OK, wait, warning or error, in plain language.

import { message } from "./strings.js";

/** The status at the bottom right. */
export class StatusCorner {
  #strings;
  #shown = "";

  constructor(strings) {
    this.#strings = strings;
  }

  /** `level`: "ok", "wait", "warning" or "error"; `key`: its string key, or `texts`: {text, do};
   *  `turned`: [degrees, of degrees] of the last step, while the profile is not tuned. */
  update({ level, key, turned, texts = this.#strings.message(key) }) {
    if (key === "untuned") {
      texts = { ...texts, do: turned ? texts.do.replace(/{(.)}/g, (_, at) => turned[at]) : "" };
    }
    const shown = `${level} ${texts.text} ${texts.do}`;
    if (shown === this.#shown) return;
    this.#shown = shown;
    const corner = document.getElementById("status");
    corner.dataset.level = level;
    message(corner, this.#strings.label(level), texts);
  }
}
