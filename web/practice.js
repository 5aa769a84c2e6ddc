// Practice mode: the targets work and count, but nothing that could move the chair is sent.

/** Counts the choices, and simulates the board. */
export class Practice {
  on = false;
  armed = false;
  #strings;
  #counts = {};
  #edge = 0;

  constructor(strings) {
    this.#strings = strings;
  }

  /** Begins or ends; resets the counts. */
  toggle() {
    this.on = !this.on;
    this.armed = false;
    this.#counts = {};
    this.#edge = 0;
    document.body.dataset.practice = this.on;
    this.#show();
  }

  /** "Rijden aan" or "Rijden uit" was chosen. */
  arm() {
    this.armed = !this.armed;
  }

  /** A command that would have been sent; `verb`: a label, or another name. */
  drive(verb, edge) {
    if (edge === this.#edge) return;
    this.#edge = edge;
    this.#counts[verb] = (this.#counts[verb] ?? 0) + 1;
    this.#show();
  }

  #show() {
    const counts = Object.entries(this.#counts);
    const words = counts.map(([verb, count]) => `${this.#strings.label(verb) ?? verb} ${count}`);
    const score = words.join(" · ") || this.#strings.label("practice_begin");
    document.getElementById("score").textContent = this.on ? score : "";
  }
}
