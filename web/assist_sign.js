// Shows what assist (Rijhulp) does on the tile of Vooruit.

import { setText } from "./dom.js";
import { tableOf } from "./strings.js";

let labels = null;

const link = document.createElement("link");
[link.rel, link.href] = ["stylesheet", "/static/assist_sign.css"];
const sign = document.createElement("span");
[sign.id, sign.className] = ["assist-sign", "small"];
document.head.append(link);
document.getElementById("forward").append(sign);

/** null: fetched again with the next state. */
async function fetchTexts(language) {
  labels = {};
  labels = await tableOf(language, "assist").then(
    (table) => table.labels,
    () => null,
  );
}

/** The host's [it sees enough to help, it steers, it waits]; null: off for this driver. */
export function show(news, { language }) {
  sign.hidden = !news;
  if (!news) return;
  if (!labels) fetchTexts(language);
  const [works, steers, waits] = news;
  sign.dataset.acts = works && (steers || waits);
  const does = waits ? "assist_waits" : steers ? "assist_steers" : "assist_on";
  const key = works ? does : "assist_blind";
  setText("assist-sign", labels[key] ?? "");
}
