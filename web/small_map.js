// A small map for the driver, in the status corner while all is OK and there is room.

import { MapPicture } from "./map_picture.js";
import { MapView } from "./map_view.js";

/** Shortest interval between updates. */
const CALM_MS = 2000;

const link = document.createElement("link");
[link.rel, link.href] = ["stylesheet", "/static/small_map.css"];
const canvas = document.createElement("canvas");
canvas.id = "small-map";
canvas.setAttribute("aria-hidden", "true");
canvas.hidden = true;
const status = document.getElementById("status");
document.head.append(link);
status.after(canvas);
const view = new MapView(canvas, () => {});
const picture = new MapPicture(view, (known) => {
  canvas.hidden = !known;
  look();
});

let movedMs = -Infinity;

/** Shown only where the status leaves room for it. */
function look() {
  const words = document.createRange();
  words.selectNodeContents(status);
  const below = words.getBoundingClientRect().bottom > canvas.getBoundingClientRect().top;
  canvas.dataset.fits = status.dataset.level === "ok" && !below;
}
new MutationObserver(look).observe(status, { childList: true, subtree: true, attributes: true });
addEventListener("resize", look);
link.onload = look;

/** The chair's pose from the host (null: not known), and its present or planned path. */
export function show(where, _strings, { going, spot }) {
  const now = performance.now();
  if (now - movedMs < CALM_MS) return;
  movedMs = now;
  picture.show(where?.map ?? "", where?.version);
  if (!where) canvas.hidden = true;
  const here = (one) => one?.goal?.map === picture.map && !["arrived", "ended"].includes(one.state);
  view.way([going, spot].find(here) ?? null);
  view.chair(where);
}
