// The corner that always says how things are: OK, warning or error, in plain words.

/** The status at the bottom right. */
export class StatusCorner {
  #strings;
  #shown = "";

  constructor(strings) {
    this.#strings = strings;
  }

  /** `level`: "ok", "warning" or "error"; `key`: the message's string key. */
  update(level, key) {
    if (`${level} ${key}` === this.#shown) return;
    this.#shown = `${level} ${key}`;
    const message = this.#strings.message(key);
    const corner = document.getElementById("status");
    corner.dataset.level = level;
    corner.querySelector(".level").textContent = this.#strings.label(level);
    corner.querySelector(".text").textContent = message.text;
    corner.querySelector(".do").textContent = message.do;
  }
}
