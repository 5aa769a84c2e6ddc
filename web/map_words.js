// The words about maps: their own texts, else the page's; signs of places.

import { PartWords } from "./part_words.js";
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
  const table = await tableOf(strings.language, "maps");
  return new MapWords(table, strings, "?");
}

class MapWords extends PartWords {
  number(value, digits) {
    return this.strings.number(value, digits);
  }

  /** A day and the time, as people write them. */
  moment(iso) {
    if (!iso) return this.unknown;
    const form = { dateStyle: "long", timeStyle: "short" };
    return new Date(iso).toLocaleString(this.strings.language, form);
  }
}
