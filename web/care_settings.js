// Forms for the chair's settings and each person's own: rows from the host's limits.

import { button, element } from "./elements.js";
import { post } from "./post.js";
import { sureButton } from "./sure.js";

/** How numbers are shown: by the end of their name, [unit shown, raw value of one unit]. */
const UNITS = [
  ["_ms", "s", 1000],
  ["_permille", "%", 10],
  ["_q4_deg", "°", 16],
  ["_percent", "%", 1],
  ["_s", "s", 1],
];
const unitOf = (name) => UNITS.find(([end]) => name.endsWith(end)) ?? ["", "", 1];

/** A labelled control; `changed(value)` receives every new value; "begun" marks a started edit. */
function row(strings, name, field, value, changed) {
  const label = element("label", "row");
  label.addEventListener("input", () => (label.dataset.begun = "true"));
  label.addEventListener("change", () => delete label.dataset.begun);
  label.addEventListener("focusout", () => {
    delete label.dataset.begun; // put back as it was: no change
    // Later, as this row may be about to go.
    queueMicrotask(() => label.newest && label.replaceWith(label.newest));
  });
  const [, unit, scale] = unitOf(name);
  const word = element("span", "", (strings.label(name) ?? name) + (unit && ` (${unit})`));
  const control = field.choices
    ? choiceOf(field, value, changed)
    : entryOf(field, value, scale, changed);
  control.name = name;
  label.append(word, control);
  return label;
}

function choiceOf({ choices }, value, changed) {
  const control = element("select");
  for (const [choice, text] of choices) control.append(new Option(text, choice));
  control.value = value;
  control.addEventListener("change", () => changed(control.value));
  return control;
}

/** A check box, a number or a text. */
function entryOf(field, value, scale, changed) {
  const control = element("input");
  control.type = typeof value === "boolean" ? "checkbox" : field.high ? "number" : "text";
  if (control.type === "checkbox") control.checked = value;
  else control.value = field.high ? value / scale : value;
  if (field.high) {
    [control.min, control.max] = [field.low / scale, field.high / scale];
    control.step = (field.step ?? 1) / scale;
  } else if (control.type === "text") control.maxLength = field.longest ?? 40;
  const shown = control.value;
  control.addEventListener("change", () => {
    // An emptied number, or none, is not 0.
    if (control.type === "number" && control.value === "") control.value = shown;
    else if (control.type === "checkbox") changed(control.checked);
    else changed(field.high ? Math.round(Number(control.value) * scale) : control.value.trim());
  });
  return control;
}

/** Draws a form; a row with a started edit stays, so that no answer discards what is typed. */
function draw(root, whose, rows) {
  const same = root.dataset.whose === whose && root.children.length === rows.length;
  root.dataset.whose = whose;
  if (!same) return root.replaceChildren(...rows);
  const old = [...root.children];
  const name = root.contains(document.activeElement) && document.activeElement.name;
  rows.forEach((one, at) => {
    if (old[at].dataset.begun) old[at].newest = one;
    else old[at].replaceWith(one);
  });
  if (name) root.querySelector(`[name="${name}"]`).focus();
}

/** The board's settings; read when shown, saved one by one. */
export class ChairSettings {
  #root;
  #strings;
  #refuse;

  constructor(root, strings, refuse) {
    this.#root = root;
    this.#strings = strings;
    this.#refuse = refuse;
  }

  load() {
    return this.#ask({ cache: "no-store" });
  }

  async #ask(request) {
    let answer;
    try {
      answer = await (await fetch("/settings", request)).json();
    } catch {
      answer = { reason: "no_answer" };
    }
    if (answer.settings) this.#show(answer.settings);
    else this.#refuse(answer.reason);
    return Boolean(answer.settings);
  }

  #show(settings) {
    const rows = Object.entries(settings).map(([name, field]) => {
      const choices = field.choices?.map((word, value) => [value, word]);
      return row(this.#strings, name, choices ? { choices } : field, field.value, async (value) => {
        const stored = await this.#ask(post({ set: { [name]: Number(value) } }));
        // Refused: show what is in force, as far as that is known.
        if (!stored && !(await this.load())) this.#show(settings);
      });
    });
    draw(this.#root, "chair", rows);
  }
}

/** The drivers: who drives now, and each person's times and display. */
export class PersonSettings {
  #root;
  #strings;
  #profiles;
  #refuse;
  #shown = null;

  constructor(root, strings, profiles, refuse) {
    this.#root = root;
    this.#strings = strings;
    this.#profiles = profiles;
    this.#refuse = refuse;
    this.#show();
  }

  /** The host has this revision of the profiles. */
  async update(revision) {
    if (revision === this.#shown) return;
    this.#shown = revision;
    await this.#profiles.reload();
    this.#show();
  }

  /** [id, name] of everybody who drives. */
  get people() {
    return this.#profiles.all.map(({ id, name }) => [id, name]);
  }

  choose(id) {
    return this.#change({ choose: id });
  }

  async #change(request) {
    const reason = await this.#profiles.change(request);
    if (reason) this.#refuse(reason);
    this.#show();
  }

  #show() {
    this.#shown = this.#profiles.revision;
    const mine = this.#profiles.current;
    const label = (key) => this.#strings.label(key);
    const people = { choices: this.people };
    const rows = [
      row(this.#strings, "person", people, mine.id, (choose) => this.#change({ choose })),
    ];
    for (const [name, value] of Object.entries(mine)) {
      if (name === "id") continue;
      const field = { ...this.#profiles.field(name) };
      if (field.choices) {
        field.choices = field.choices.map((choice) => [choice, this.#word(name, choice)]);
      }
      const save = (changed) => this.#change({ save: { id: mine.id, [name]: changed } });
      rows.push(row(this.#strings, name, field, value, save));
    }
    const buttons = element("p", "buttons");
    buttons.append(
      button(label("care_new_person"), () => this.#change({ create: label("care_someone") })),
      sureButton(label("care_delete_person"), label("care_sure"), () =>
        this.#change({ delete: mine.id }),
      ),
    );
    draw(this.#root, mine.id, [...rows, buttons]);
  }

  #word(name, choice) {
    const keys = [`${name}_${choice}`, choice, `look_${choice}`];
    return keys.map((key) => this.#strings.label(key)).find(Boolean) ?? choice;
  }
}
