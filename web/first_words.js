// The words of the first drive: its own texts and facts, else the page's.

import { tableOf } from "./table.js";

/** The words in this language, Dutch when there are none. Throws without answer. */
export async function firstWords(strings) {
  return new FirstWords(await tableOf(strings.language, "first"), strings);
}

/** Texts of steps; facts are rows of GET /first-drive. */
class FirstWords {
  #table;
  #strings;

  constructor(table, strings) {
    this.#table = table;
    this.#strings = strings;
  }

  /** A word, with what is in {braces} filled in. */
  label(key, fields = {}) {
    const text = this.#table.labels[key] ?? this.#strings.label(key) ?? key;
    return text.replace(/{(\w+)}/g, (_, name) => fields[name] ?? this.#table.labels.first_unknown);
  }

  /** One line: what a reason says, and what to do. */
  reason(key) {
    const { text, do: advice } = this.#table.messages[key] ?? this.#strings.message(key);
    return `${text} ${advice}`.trim();
  }

  /** Why a step failed: in this language, else as the host said it, in English. */
  told({ told, fields, detail }) {
    const text = this.#table.told?.[told];
    if (!text) return detail;
    const word = (name, value) => {
      if (name === "reason") return this.reason(value);
      return typeof value === "number" ? value.toLocaleString(this.#strings.language) : value;
    };
    return text.replace(/{(\w+)}/g, (_, name) => word(name, fields[name]));
  }

  /** What is known about a step, in one line. */
  fact(row) {
    const say = (key, fields) => this.label(`first_fact_${key}`, fields);
    const cm = (mm) => (mm === null ? null : Math.round(mm / 10));
    const number = (value) => this.#strings.number(Math.abs(value), 1);
    switch (row.step) {
      case "mask": {
        const arcs = row.arcs.flat().map(([from, to]) => `${from}..${to}°`);
        return say("mask", { arcs: arcs.join(", ") || this.label("first_nothing") });
      }
      case "distance": {
        const found = row.found?.map(cm);
        const last = found ? say("found", { tape: found[0], lidar: found[1] }) : "";
        return `${say("distance", { seen: cm(row.seen_mm) })} ${last}`;
      }
      case "neutral":
        return say("neutral", { linear: row.counts?.[0], turn: row.counts?.[1] });
      case "turn": {
        if (!row.turned_deg) return "";
        const [left, right] = row.turned_deg.map(number);
        return say("turn", { left, right, wanted: row.wanted_deg });
      }
      case "tune":
        return say("profile", row);
      case "person":
        return row.name ? say("person", row) : "";
      case "relay":
      case "practice":
        return "";
      default:
        return say(row.step, row);
    }
  }
}
