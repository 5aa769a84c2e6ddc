// The texts about maps: their own, else the page's.

import { PartTexts } from "./part_texts.js";
import { tableOf } from "./strings.js";

/** The texts in this language, else in Dutch. Throws when the host does not answer. */
export async function mapTexts(strings) {
  const table = await tableOf(strings.language, "maps");
  return new MapTexts(table, strings, "?");
}

class MapTexts extends PartTexts {
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
