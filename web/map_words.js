// The words about maps: their own texts, else the page's; signs of places.

import { tableOf } from "./table.js";

/** Signs by the names that the host knows them by. */
export const ICONS = {
  star: "★",
  bed: "🛏️",
  sofa: "🛋️",
  table: "🍽️",
  desk: "💻",
  kitchen: "🍳",
  toilet: "🚽",
  bath: "🛁",
  tv: "📺",
  window: "🪟",
  door: "🚪",
  garden: "🌳",
  lift: "🛗",
  charger: "🔌",
};

/** The words in this language, Dutch when there are none. Throws without answer. */
export async function mapWords(strings) {
  return new MapWords(await tableOf(strings.language, "maps"), strings);
}

class MapWords {
  #table;
  #strings;

  constructor(table, strings) {
    this.#table = table;
    this.#strings = strings;
  }

  /** A word, with what is in {braces} filled in. */
  label(key, fields = {}) {
    const text = this.#table.labels[key] ?? key;
    return text.replace(/{(\w+)}/g, (_, name) => fields[name] ?? "?");
  }

  /** One line: what a reason says, and what to do. */
  reason(key) {
    const { text, do: advice } = this.#table.messages[key] ?? this.#strings.message(key);
    return `${text} ${advice}`.trim();
  }

  number(value, digits) {
    return this.#strings.number(value, digits);
  }

  day(iso) {
    return iso ? new Date(iso).toLocaleDateString(this.#strings.language) : "";
  }
}
