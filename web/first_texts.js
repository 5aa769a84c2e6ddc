// The texts of the first drive: its own texts and facts, else the page's.

import { PartTexts } from "./part_texts.js";
import { tableOf } from "./strings.js";

/** The texts in this language, else in Dutch. Throws when the host does not answer. */
export async function firstTexts(strings) {
  const table = await tableOf(strings.language, "first");
  return new FirstTexts(table, strings, table.labels.first_unknown);
}

/** Texts of steps; facts are rows of GET /first-drive. */
class FirstTexts extends PartTexts {
  /** Why a step failed: in this language, else the host's English text. */
  failure({ error, fields, detail }) {
    const text = this.table.errors?.[error];
    if (!text) return detail;
    const word = (name, value) => {
      if (name === "reason") return this.reason(value);
      return typeof value === "number" ? value.toLocaleString(this.strings.language) : value;
    };
    return text.replace(/{(\w+)}/g, (_, name) => word(name, fields[name]));
  }

  /** What is known about a step, in one line. */
  fact(row) {
    const say = (key, fields) => this.label(`first_fact_${key}`, fields);
    const cm = (mm) => (mm === null ? null : Math.round(mm / 10));
    const number = (value) => this.strings.number(Math.abs(value), 1);
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
      case "camera": {
        if (!row.found) return say("camera_none");
        if (!row.found.fits) return say("camera_shape");
        return say("camera", { error: number(row.found.residual_mm / 10) });
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
