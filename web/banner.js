// The large words in the middle: why the board overrules the driver, or why a wish was refused.

/** An override stays readable for at least this long. */
const OVERRIDE_MS = 1500;
/** A refusal or hint, which has no end of its own, is shown for this long. */
const NOTICE_MS = 4000;

/** The banner; an override is shown (and heard) at once and comes before any notice. */
export class Banner {
  #strings;
  #tone;
  #element = document.getElementById("banner");
  #override = "none";
  #untilMs = 0;

  constructor(strings, tone) {
    this.#strings = strings;
    this.#tone = tone;
  }

  /** The board's present override, "none" when the driver's command stands. */
  override(key, now) {
    if (key === this.#override) return;
    this.#override = key;
    if (key === "none") return;
    this.#render("override", this.#strings.label("overruled"), this.#strings.message(key));
    this.#untilMs = now + OVERRIDE_MS;
    this.#tone.play();
  }

  /** A short notice: a label as title, a message key as reason. */
  notice(title, key, now) {
    if (this.#override !== "none") return;
    this.#render("notice", this.#strings.label(title), this.#strings.message(key));
    this.#untilMs = now + NOTICE_MS;
  }

  tick(now) {
    if (this.#override !== "none" || now < this.#untilMs) return;
    if (this.#element.dataset.kind !== "none") this.#element.dataset.kind = "none";
  }

  #render(kind, title, message) {
    this.#element.dataset.kind = kind;
    this.#element.querySelector(".title").textContent = title;
    this.#element.querySelector(".text").textContent = message.text;
    this.#element.querySelector(".do").textContent = message.do;
  }
}
