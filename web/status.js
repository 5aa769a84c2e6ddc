// The status corner: always shows OK, wait, warning or error, in plain language.

import { message } from "./strings.js";

/** The status at the bottom right. */
export class StatusCorner {
  #strings;
  #shown = "";

  constructor(strings) {
    this.#strings = strings;
  }

  /** `level`: "ok", "wait", "warning" or "error"; `key`: its string key, or `said`: {text, do};
   *  `turned`: [degrees, of degrees] of the last step, while the profile is not tuned. */
  update({ level, key, turned, said = this.#strings.message(key) }) {
    if (key === "untuned") {
      said = { ...said, do: turned ? said.do.replace(/{(.)}/g, (_, at) => turned[at]) : "" };
    }
    const shown = `${level} ${said.text} ${said.do}`;
    if (shown === this.#shown) return;
    this.#shown = shown;
    const corner = document.getElementById("status");
    corner.dataset.level = level;
    message(corner, this.#strings.label(level), said);
  }
}
