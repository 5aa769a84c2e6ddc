// The texts about maps: their own, else the page's.

import { PartWords } from "./part_words.js";
import { tableOf } from "./strings.js";

/** The texts in this language, else in Dutch. Throws when the host does not answer. */
export async function mapWords(strings) {
  const table = await tableOf(strings.language, "maps");
  return new MapWords(table, strings, "?");
}

class MapWords extends PartWords {
  number(value, digits) {
    return this.strings.number(value, digits);
  }

  /** Date and time in this language's format. */
  moment(iso) {
    if (!iso) return this.unknown;
    const form = { dateStyle: "long", timeStyle: "short" };
    return new Date(iso).toLocaleString(this.strings.language, form);
  }
}
