// A button that works only while pressed: by finger, mouse, Enter or space.

const isKey = (event) => event.key === "Enter" || event.key === " ";

/** `on` receives begin(), held() at once and at every heartbeat, end(). */
export class Held {
  #on;
  #element;
  #heartbeatMs = 50;
  #source = null;
  #againAt = 0;

  constructor(element, on) {
    this.#element = element;
    this.#on = on;
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      this.#begin("pointer");
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(end, () => this.#source === "pointer" && this.end());
    }
    element.addEventListener("keydown", (event) => {
      if (!isKey(event)) return;
      event.preventDefault();
      if (!event.repeat) this.#begin("key");
    });
    // The focus may move while the key is down: another element is then told of its release.
    const letGo = () => this.#source === "key" && this.end();
    element.addEventListener("blur", letGo);
    addEventListener("keyup", (event) => isKey(event) && letGo());
  }

  setHeartbeat(ms) {
    this.#heartbeatMs = ms;
  }

  end() {
    if (this.#source === null) return;
    this.#source = null;
    this.#element.classList.remove("down");
    this.#on.end();
  }

  tick(now) {
    if (this.#source === null || now < this.#againAt) return;
    this.#againAt = now + this.#heartbeatMs;
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
