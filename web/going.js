// Texts about auto motions, for the driver's page and the caretaker's.

import { cut, isolated } from "./plugins.js";
import { tableOf } from "./strings.js";

const NAME = 24;
/** The tone of an arrival; see Tones. */
export const ARRIVED = [
  [523, 0.1, "sine"],
  [659, 0.1, "sine"],
  [784, 0.2, "sine"],
];

/** The texts in this language, else in Dutch. Throws when the host does not answer. */
export async function goingTexts(strings) {
  return new GoingTexts(await tableOf(strings.language, "going"), strings);
}

/** Texts about `going` in the host's state. */
class GoingTexts {
  #table;
  #strings;

  constructor(table, strings) {
    this.#table = table;
    this.#strings = strings;
  }

  label(key) {
    return this.#table.labels[key];
  }

  /** What Forward asks: to pause the motion that drives, or to go on with the ended one. */
  asks(rides, again, texts) {
    return rides ? this.label("going_pause") : again && texts.label("plugin_go_on");
  }

  /** Remaining distance: "nog 4,2 m"; "" while unknown. */
  left({ left_m: left }) {
    if (!(left > 0)) return "";
    return this.label("going_left").replace("{m}", this.#strings.number(left, 1));
  }

  /** {text, do}: what the chair does, or why it stands, and what to do. */
  status({ kind, state, reason, name }) {
    const { text, do: advice } = this.#message(kind, reason, `going_${state}`);
    return { text: text.replace("{name}", () => isolated(cut(name, NAME))), do: advice };
  }

  /** {text, do} for choosing a spot for a tile, or for the chosen one. */
  spot({ kind, state, reason }) {
    return this.#message(kind, reason, `spot_${state}`);
  }

  /** The text of the reason, else of the state: for that kind, else for all. */
  #message(kind, reason, state) {
    const { messages } = this.#table;
    const key = reason || state;
    return messages[`${key}_${kind}`] ?? messages[key] ?? this.#strings.message(reason);
  }

  /** The motion's state, if the page's sentence, `message`, is that all is OK; else `message`. */
  sentence(message, going) {
    if (!going || message.level !== "ok") return message;
    const texts = this.status(going);
    const left = going.state === "drives" ? this.left(going) : "";
    const level = going.state === "ended" || going.state === "blocked" ? "warning" : "ok";
    const advice = left || texts.do;
    return { ...message, level, key: "going", texts: { text: texts.text, do: advice } };
  }
}
