// The large words in the middle: why the board overrules the driver, or why a wish was refused.

/** An override stays readable for at least this long. */
const OVERRIDE_MS = 1500;
/** A refusal or hint, which has no end of its own, is shown for this long. */
const NOTICE_MS = 4000;

/** The banner; an override is shown (and heard) at once and comes before any notice. */
export class Banner {
  #strings;
  #tones;
  #element = document.getElementById("banner");
  #override = "none";
  #shown = "";
  #untilMs = 0;

  constructor(strings, tones) {
    this.#strings = strings;
    this.#tones = tones;
  }

  /** The board's present override, "none" when the driver's command stands. */
  override(key, now) {
    if (key === this.#override) return;
    this.#override = key;
    if (key === "none") return;
    this.#render("override", this.#strings.label("overruled"), key);
    this.#untilMs = now + OVERRIDE_MS;
    this.#tones.play("override");
  }

  /** A short notice: a label as title, a message key as reason. */
  notice(title, key, now) {
    if (this.#override !== "none") return;
    this.#render("notice", this.#strings.label(title), key);
    this.#untilMs = now + NOTICE_MS;
  }

  tick(now) {
    if (this.#override !== "none" || now < this.#untilMs) return;
    if (this.#element.dataset.kind === "none") return;
    this.#element.dataset.kind = "none";
    delete this.#element.dataset.key;
    this.#shown = "";
  }

  #render(kind, title, key) {
    if (this.#shown === `${kind} ${title} ${key}`) return; // a refusal comes once per command
    this.#shown = `${kind} ${title} ${key}`;
    const message = this.#strings.message(key);
    this.#element.dataset.kind = kind;
    this.#element.dataset.key = key;
    this.#element.querySelector(".title").textContent = title;
    this.#element.querySelector(".text").textContent = message.text;
    this.#element.querySelector(".do").textContent = message.do;
  }
}
