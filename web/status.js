// The corner that always says how things are: OK, warning or error, in plain words.

/** Host messages that only a person standing by clears, by pressing the reset button. */
const LATCHED = ["wiper", "tick_exception", "emergency", "watchdog_boots"];

/** The status at the bottom right; calls `moved()` when its reset button may have moved. */
export class StatusCorner {
  #strings;
  #moved;
  #shown = "";

  constructor(strings, moved) {
    this.#strings = strings;
    this.#moved = moved;
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
    document.getElementById("reset").classList.toggle("shown", LATCHED.includes(key));
    this.#moved();
  }
}
