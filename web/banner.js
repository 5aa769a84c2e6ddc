// The large banner in the middle: who took over, why the board overrides, why a request failed.

import { message } from "./strings.js";

/** An override stays readable for at least this long. */
const OVERRIDE_MS = 1500;
/** A refusal or hint, which does not end by itself, is shown for this long. */
const NOTICE_MS = 4000;

/** The banner; an override is shown (and sounded) at once; it and a take-over have priority. */
export class Banner {
  #strings;
  #tones;
  #element = document.getElementById("banner");
  #steady = "none";
  #shown = "";
  #untilMs = 0;

  constructor(strings, tones) {
    this.#strings = strings;
    this.#tones = tones;
  }

  /** Shows the sentence's part: "override" with its reason, "taken" with a label, or nothing. */
  steady(kind, words, now) {
    const steady = kind === "override" || kind === "taken" ? `${kind} ${words}` : "none";
    if (steady === this.#steady) return;
    this.#steady = steady;
    // Driving is off: hide it.
    if (steady === "none" && kind !== "none") this.#untilMs = now;
    if (kind === "taken") {
      const text = this.#strings.label("taken_text");
      this.#render(kind, this.#strings.label(words), words, { text, do: "" });
      this.#untilMs = now;
    } else if (steady !== "none") {
      this.#render(kind, this.#strings.label("overruled"), words, this.#strings.message(words));
      this.#untilMs = now + OVERRIDE_MS;
      this.#tones.play("override");
    }
  }

  /** A short notice: a label as title, a message key as reason. */
  notice(title, key, now) {
    if (this.#steady !== "none") return;
    this.#render("notice", this.#strings.label(title), key, this.#strings.message(key));
    this.#untilMs = now + NOTICE_MS;
  }

  tick(now) {
    if (this.#steady !== "none" || now < this.#untilMs || this.#shown === "") return;
    this.#element.dataset.kind = "none";
    delete this.#element.dataset.key;
    this.#shown = "";
  }

  #render(kind, title, key, words) {
    // A refusal comes once per command.
    if (this.#shown === `${kind} ${title} ${key}`) return;
    this.#shown = `${kind} ${title} ${key}`;
    this.#element.dataset.kind = kind;
    this.#element.dataset.key = key;
    message(this.#element, title, words);
  }
}
