// Where the chair takes itself, in words: for the driver's page and the caretaker's.

import { tableOf } from "./table.js";

/** A name that may run from right to left keeps that to itself. */
const ISOLATE = "\u2068";
const END_ISOLATE = "\u2069";
const NAME = 24;
/** The tone of an arrival; see Tones. */
export const ARRIVED = [
  [523, 0.1, "sine"],
  [659, 0.1, "sine"],
  [784, 0.2, "sine"],
];

/** The words in this language, Dutch when there are none. Throws without answer. */
export async function goingWords(strings) {
  return new GoingWords(await tableOf(strings.language, "going"), strings);
}

/** Words about `going` of the host's state. */
class GoingWords {
  #table;
  #strings;

  constructor(table, strings) {
    this.#table = table;
    this.#strings = strings;
  }

  label(key) {
    return this.#table.labels[key];
  }

  /** How far it still is: "nog 4,2 m"; "" while that is not known. */
  left({ left_m: left }) {
    if (!(left > 0)) return "";
    return this.label("going_left").replace("{m}", this.#strings.number(left, 1));
  }

  /** {text, do}: what it does, or why it does not, and what to do. */
  says({ kind, state, reason, name }) {
    const { text, do: advice } = this.#message(kind, reason, `going_${state}`);
    const cut = [...String(name)].slice(0, NAME).join("");
    return { text: text.replace("{name}", ISOLATE + cut + END_ISOLATE), do: advice };
  }

  /** {text, do} of a spot that is to be chosen for a tile, or was. */
  spot({ kind, state, reason }) {
    return this.#message(kind, reason, `spot_${state}`);
  }

  /** What the reason says, else what the state is: of that kind, else of all. */
  #message(kind, reason, state) {
    const { messages } = this.#table;
    const key = reason || state;
    return messages[`${key}_${kind}`] ?? messages[key] ?? this.#strings.message(reason);
  }

  /** The page's sentence `told`; where that is that all is well, how the motion goes. */
  sentence(told, going) {
    if (!going || told.level !== "ok") return told;
    const said = this.says(going);
    const left = going.state === "drives" ? this.left(going) : "";
    const level = going.state === "ended" || going.state === "blocked" ? "warning" : "ok";
    return { ...told, level, key: "going", said: { text: said.text, do: left || said.do } };
  }
}
