// A small map for the driver, in the status corner while all is OK and there is room.

import { MapView } from "./map_view.js";

/** Shortest interval between updates. */
const CALM_MS = 2000;
const NOTHING = { places: [], no_go: [], home: null };

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

let map = ""; // shown
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
link.onload = look; // now the canvas has its place

async function open(id) {
  map = id;
  view.clear();
  try {
    const answer = await fetch(`/maps/${id}`, { cache: "no-store" });
    if (!answer.ok) throw new Error(`the host answered ${answer.status}`);
    const { picture } = await answer.json();
    if (id !== map) return; // another map meanwhile
    canvas.hidden = false;
    view.show(NOTHING, { points: [], closed: false });
    look();
    if (!(await view.picture(`/maps/${id}.png`, picture))) throw new Error("no picture");
  } catch (error) {
    console.warn(`small map: ${error.message}`);
    if (id !== map) return;
    canvas.hidden = true;
    map = ""; // request it again
  }
}

/** The chair's pose from the host (null: not known), and its present or planned path. */
export function show(where, _strings, { going, spot }) {
  const now = performance.now();
  if (now - movedMs < CALM_MS) return;
  movedMs = now;
  if (where && where.map !== map) open(where.map);
  if (!where) {
    canvas.hidden = true;
    map = "";
  }
  const here = (one) => one?.goal?.map === map && !["arrived", "ended"].includes(one.state);
  view.way([going, spot].find(here) ?? null);
  view.chair(where);
}
