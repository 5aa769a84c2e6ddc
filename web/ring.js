// The ring that fills while the driver looks at a target, and the mark of the active target.

import { svg } from "./dom.js";

/** Gives every target's picture its ring. */
export function addRings() {
  const ring = svg("circle", { class: "ring", cx: 50, cy: 50, r: 45, pathLength: 100 });
  for (const mark of document.querySelectorAll(".mark")) mark.prepend(ring.cloneNode());
}

/** The target looked at, with its `dwellMs`, and the held one, by name; null for none. */
export function showChosen(dwelling, holding, dwellMs) {
  if (dwelling) document.body.style.setProperty("--dwell", `${dwellMs}ms`);
  for (const target of document.querySelectorAll(".target")) {
    target.classList.toggle("dwelling", target.id === dwelling);
    target.classList.toggle("holding", target.id === holding);
  }
}
