// The slider of the cap on the caretaker's page: the cap in force, or the new one while it is set.

import { byId, setText } from "./dom.js";

/** A released slider keeps its place for this long: meanwhile the host confirms the cap. */
const SETTLES_MS = 1000;

export class CapSlider {
  #strings;
  #slider = byId("cap");
  #held = false; // a finger or the mouse is on it, perhaps at rest
  #movedMs = -Infinity;

  /** `send(permille)` receives a new cap, when the slider is released. */
  constructor(strings, send) {
    this.#strings = strings;
    const slider = this.#slider;
    slider.addEventListener("pointerdown", () => (this.#held = true));
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => this.#letGo());
    slider.addEventListener("input", () => this.#moved());
    slider.addEventListener("change", () => send(Number(slider.value)));
  }

  /** The host's cap. */
  update(permille) {
    const mine = this.#held || performance.now() - this.#movedMs < SETTLES_MS;
    if (!mine && Number(this.#slider.value) !== permille) this.#slider.value = permille;
    this.#show(mine ? Number(this.#slider.value) : permille);
  }

  #letGo() {
    if (this.#held) this.#moved();
    this.#held = false;
  }

  #moved() {
    this.#movedMs = performance.now();
    this.#show(Number(this.#slider.value));
  }

  #show(permille) {
    const none = this.#strings.label("care_no_cap");
    setText("cap-word", permille >= 1000 ? none : `${permille / 10} %`);
  }
}
