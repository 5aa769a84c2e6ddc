// The first drive on the caretaker's page: its steps, one open at a time; facts come from the host.

import { button, element, put } from "./elements.js";
import { FloorMarks } from "./floor_marks.js";
import { firstTexts } from "./first_texts.js";
import { HeldButton } from "./held_button.js";
import { post } from "./post.js";

const POLL_MS = 500;
/** Steps that move the chair: only while their button is held. */
const MOVES = ["relay", "tune", "turn"];
/** Steps that only inform. */
const TELLS = ["versions", "practice"];
const MM = 10;

/** Offers [[value, text]], unless it does already; what was chosen stays so. */
const offer = (select, options) => {
  const shown = [...select.options].map(({ value, textContent }) => [value, textContent]);
  const wanted = options.map(([value, text]) => [String(value), text]);
  if (JSON.stringify(shown) === JSON.stringify(wanted)) return;
  const chosen = select.value;
  select.replaceChildren(...wanted.map(([value, text]) => new Option(text, value)));
  if (wanted.some(([value]) => value === chosen)) select.value = chosen;
};

/** The list, ready to be shown; throws when its texts do not load. */
export async function firstDrive(root, strings, on) {
  return new FirstDrive(root, await firstTexts(strings), on);
}

/** `on`: hold(step, edge), letGo() and edge(); people(): [[id, name]] and choose(id). */
class FirstDrive {
  #root;
  #texts;
  #on;
  #rows = new Map();
  #open = null; // the step that is shown
  #held = [];
  #polledMs = -Infinity;
  #asking = false;
  #status = null;
  #marks;

  constructor(root, texts, on) {
    this.#root = root;
    this.#texts = texts;
    this.#on = on;
    this.#marks = new FloorMarks(texts, (value) => this.#post({ run: "camera", value }));
  }

  /** Ends every hold. */
  end() {
    for (const held of this.#held) held.end();
  }

  tick(now) {
    for (const held of this.#held) held.tick(now);
    if (this.#asking || now - this.#polledMs < POLL_MS) return;
    this.#polledMs = now;
    this.load();
  }

  /** Requests the state from the host. */
  load() {
    return this.#ask({ cache: "no-store" });
  }

  /** Shows the host's refusal of the held button or of a request, until the next one. */
  refused(reason) {
    const row = this.#rows.get(this.#open);
    const text = this.#reasonText(reason);
    if (row) [row.refusal, row.late] = [text, reason === "stale_token"];
    return text;
  }

  /** Shows the reason until the host's next answer. */
  #reasonText(reason) {
    const row = this.#rows.get(this.#open);
    const text = this.#texts.reason(reason);
    if (row) put(row.status, text);
    return text;
  }

  /** The open step is tried again. */
  #forget() {
    this.#rows.get(this.#open).refusal = "";
  }

  #post(request) {
    this.#forget();
    return this.#ask(post(request));
  }

  /** Resolves to the reason of a refusal as text; undefined: done. */
  async #ask(request) {
    this.#asking = true;
    let refusal;
    try {
      const answer = await (await fetch("/first-drive", request)).json();
      if (answer.steps) this.#show(answer);
      else refusal = request.method ? this.refused(answer.reason) : this.#reasonText(answer.reason);
    } catch (error) {
      console.warn(`first drive: ${error.message}`);
      refusal = this.#texts.reason("no_answer");
    }
    this.#asking = false;
    return refusal;
  }

  #show(status) {
    this.#status = status;
    if (this.#rows.size === 0) this.#build(status.steps);
    for (const row of status.steps) this.#update(row, status.run);
  }

  #build(steps) {
    const list = element("ol", "first");
    for (const [at, { step, choices }] of steps.entries()) {
      list.append(this.#step(step, at + 1, choices));
    }
    this.#root.replaceChildren(element("p", "note", this.#texts.label("first_intro")), list);
    this.#choose((steps.find(({ done }) => !done) ?? steps[0]).step);
  }

  /** A step: a head that opens it, and what is in it. */
  #step(step, number, choices) {
    const label = (key, fields) => this.#texts.label(key, fields);
    const item = element("li");
    const head = element("button", "head");
    head.type = "button";
    const mark = element("span", "mark");
    head.append(element("b", "", `${number}. ${label(`first_${step}`)}`), mark);
    head.addEventListener("click", () => this.#choose(step));
    const inside = element("div", "inside");
    const fact = element("p", "fact");
    const status = element("p", "status-text");
    const controls = element("p", "controls");
    inside.append(element("p", "why", label(`first_${step}_why`)), fact);
    if (!TELLS.includes(step)) inside.append(controls, status);
    item.append(head, inside);
    const news = { asks: null, shown: "", refusal: "", late: false };
    this.#rows.set(step, { item, head, mark, fact, status, controls, ...news });
    if (MOVES.includes(step)) this.#hold(step, controls);
    else if (!TELLS.includes(step)) this.#begin(step, controls, choices);
    return item;
  }

  #choose(step) {
    this.end();
    this.#open = step;
    this.#forget();
    for (const [name, { item, head }] of this.#rows) {
      item.dataset.open = name === step;
      head.ariaExpanded = String(name === step);
    }
    for (const row of this.#status?.steps ?? []) this.#update(row, this.#status.run);
  }

  #hold(step, controls) {
    const fields = { step: this.#texts.label(`first_${step}`) };
    const held = element("button", "held strong", this.#texts.label("first_hold_button", fields));
    held.type = "button";
    controls.append(held);
    let edge = 0;
    this.#held.push(
      new HeldButton(held, {
        begin: () => {
          this.#forget();
          edge = this.#on.edge();
        },
        held: () => this.#on.hold(step, edge),
        end: () => this.#on.letGo(),
      }),
    );
  }

  #begin(step, controls, choices) {
    const label = (key) => this.#texts.label(key);
    let value = () => undefined;
    let act = () => this.#post({ run: step, value: value() });
    if (step === "distance") {
      const input = element("input");
      [input.type, input.min, input.max, input.inputMode] = ["number", 1, 1200, "numeric"];
      input.ariaLabel = input.placeholder = label("first_distance_cm");
      value = () => Math.round(Number(input.value) * MM);
      controls.append(input);
    }
    if (step === "profile" || step === "person") {
      const select = element("select");
      select.ariaLabel = label(`first_${step}`);
      const profiles = choices?.map((name, at) => [at, name]);
      offer(select, step === "profile" ? profiles : this.#on.people());
      value = () => Number(select.value);
      if (step === "person") act = () => this.#on.choose(select.value).then(() => this.load());
      controls.append(select);
    }
    if (step === "camera") act = () => this.#marks.open();
    const own = { person: "first_choose", camera: "first_marks_open" };
    const text = label(own[step] ?? "first_begin");
    controls.append(button(text, () => act(), "strong"));
  }

  /** What the procedure asks, as buttons; the step's own controls when it asks nothing. */
  #answers(step, row, asks) {
    if (row.asks === asks || step !== "neutral") return;
    row.asks = asks;
    const label = (key) => this.#texts.label(key);
    const answers = {
      unplugged: [["first_unplugged", "unplugged"]],
      linear: [
        ["first_less", "-"],
        ["first_more", "+"],
        ["first_right", "ok"],
      ],
      save: [["first_save", "save"]],
    };
    answers.turn = answers.linear;
    row.controls.replaceChildren();
    if (!asks) return this.#begin(step, row.controls);
    for (const [key, answer] of answers[asks]) {
      row.controls.append(button(label(key), () => this.#post({ answer, asks })));
    }
    row.controls.append(button(label("first_give_up"), () => this.#post({ give_up: true })));
  }

  #update(row, run) {
    const { step, done, refused } = row;
    const mine = this.#rows.get(step);
    const label = (key, fields) => this.#texts.label(key, fields);
    mine.item.dataset.done = done;
    put(mine.mark, label(done ? "first_done" : "first_open"));
    if (step === "camera") this.#markRow(row, run);
    if (step !== this.#open) return;
    if (step === "person") offer(mine.controls.querySelector("select"), this.#on.people());
    put(mine.fact, this.#texts.fact(row));
    const runs = run.step === step;
    this.#answers(step, mine, runs ? run.asks : "");
    const status = this.#statusOf(step, runs, refused, run);
    // The step's own text says so now; or a late proof of holding was followed by one in time.
    if (status === mine.refusal || (mine.late && status !== mine.shown)) mine.refusal = "";
    mine.shown = status;
    put(mine.status, mine.refusal || status);
  }

  /** Once the fit has ended: its result or error. */
  #markRow(row, run) {
    const ended = run.step !== "camera" && run.ended?.step === "camera" ? run.ended : null;
    const status = ended && this.#statusOf("camera", false, "", run);
    const text = ended?.ok ? `${status} ${this.#texts.fact(row)}` : status;
    this.#marks.update(row, text, ended && { ...ended.fields });
  }

  #statusOf(step, runs, refused, { asks, pulses, straight, ended }) {
    const label = (key, fields) => this.#texts.label(key, fields);
    if (runs) {
      if (asks === "linear" || asks === "turn") {
        return label(asks === "turn" ? "first_turn_pin" : "first_linear");
      }
      if (straight > 0) return label("first_straight", { n: straight });
      return pulses > 0 ? label("first_pulses", { n: pulses }) : label("first_running");
    }
    const last = ended?.step === step ? ended : null;
    if (last && !last.ok) {
      const detail = last.reason === "first_failed" ? this.#texts.failure(last) : "";
      return `${this.#texts.reason(last.reason)} ${detail}`.trim();
    }
    if (refused) return this.#texts.reason(refused);
    return last ? label("first_well") : "";
  }
}
