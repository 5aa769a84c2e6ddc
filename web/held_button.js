// A button that works only while pressed: by finger, mouse, Enter or space.

import { heartbeatMs } from "./heartbeat.js";

const isKey = (event) => event.key === "Enter" || event.key === " ";

/** At the touch itself: while another finger is down, no click follows. */
export const atTouch = (element, act) => {
  for (const kind of ["pointerdown", "click"]) element.addEventListener(kind, () => act());
};

/** `on` receives begin(), held() at once and at every heartbeat, end(). */
export class HeldButton {
  #on;
  #element;
  #source = null; // the pointer's number, or the key's place on the keyboard
  #againAt = 0;

  constructor(element, on) {
    this.#element = element;
    this.#on = on;
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      this.#begin(event.pointerId);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(end, ({ pointerId }) => this.#source === pointerId && this.end());
    }
    // While another button of the mouse is down, a move reports that this one came up.
    element.addEventListener("pointermove", ({ pointerId, buttons }) => {
      if (this.#source === pointerId && (buttons & 1) === 0) this.end();
    });
    element.addEventListener("keydown", (event) => {
      if (!isKey(event)) return;
      event.preventDefault();
      if (!event.repeat && !event.metaKey) this.#begin(event.code);
    });
    const letGo = () => typeof this.#source === "string" && this.end();
    element.addEventListener("blur", letGo);
    // The focus may move while the key is down: another element then receives its release.
    // By its place: what a key is called changes with other keys.
    addEventListener("keyup", ({ code }) => code === this.#source && this.end());
    // macOS reports no release while this key is down.
    addEventListener("keydown", ({ key }) => key === "Meta" && letGo());
  }

  end() {
    if (this.#source === null) return;
    this.#source = null;
    this.#element.classList.remove("down");
    this.#on.end();
  }

  tick(now) {
    if (this.#source === null || now < this.#againAt) return;
    this.#againAt = now + heartbeatMs;
    this.#on.held();
  }

  #begin(source) {
    if (this.#source !== null) return;
    this.#source = source;
    this.#element.classList.add("down");
    this.#on.begin();
    this.tick(performance.now());
  }
}
