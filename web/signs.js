// Signs drawn by the page itself, as many systems have no characters for them.

import { svg } from "./dom.js";

/** Side of a sign's square. */
const SIDE = 24;

/** Filled outlines by the sign's name on the wire; overlaps are holes. */
const OUTLINES = {
  star: ["M12 2l3 6.6 7 .8-5.2 4.8 1.4 7L12 17.7l-6.2 3.5 1.4-7L2 9.4l7-.8z"],
  bed: [
    "M2 4h2.4v10H22v7h-2.4v-3H4.4v3H2zM7.8 7.4a2.4 2.4 0 0 1 0 4.8 2.4 2.4 0 0 1 0-4.8z",
    "M11.6 8H18a4 4 0 0 1 4 4v.6H11.6z",
  ],
  sofa: [
    "M7 4h10a2 2 0 0 1 2 2v3.6a3.6 3.6 0 0 0-2.4 3.4v1H7.4v-1A3.6 3.6 0 0 0 5 9.6V6a2 2 0 0 1 2-2z",
    "M3.9 11a1.9 1.9 0 0 1 1.9 1.9v2.7h12.4",
    "v-2.7a1.9 1.9 0 0 1 3.8 0V19h-2v2h-2v-2H6v2H4v-2H2v-6.1A1.9 1.9 0 0 1 3.9 11z",
  ],
  table: ["M1 7h22v3H1zM3.5 11.5H6V20H3.5zM18 11.5h2.5V20H18z"],
  desk: ["M4 4h16v11.5H4zM6 6v7.5h12V6zM1.5 17h21v2.5h-21z"],
  kitchen: [
    "M10.3 3.5h3.4v2.3h-3.4zM4 6.8h16V9H4z",
    "M5 10.2h14V18a2.5 2.5 0 0 1-2.5 2.5h-9A2.5 2.5 0 0 1 5 18zM1.5 11h2.3v3H1.5z",
    "M20.2 11h2.3v3h-2.3z",
  ],
  toilet: ["M4 2h5.5v8.6H4zM4 12h17a8 8 0 0 1-6.2 7V22H7.2v-4.4A8 8 0 0 1 4 12z"],
  bath: [
    "M4 10.8V6a3.3 3.3 0 0 1 6.6 0v1.4H8.3V6a1 1 0 0 0-2 0v4.8z",
    "M1.5 12h21v2a5.2 5.2 0 0 1-3.4 4.9l1 2.6h-2.4",
    "l-.9-2.3H7.2l-.9 2.3H3.9l1-2.6A5.2 5.2 0 0 1 1.5 14z",
  ],
  tv: ["M1.5 4h21v13.5h-21zM3.8 6.2v9h16.4v-9zM7 19h10v2.2H7z"],
  window: [
    "M3.5 2.5h17v19h-17zM5.8 4.8v6h5v-6zM13.2 4.8v6h5v-6zM5.8 13.2v6h5v-6z",
    "M13.2 13.2v6h5v-6z",
  ],
  door: [
    "M4.5 1.5h15v21h-2.3V3.8H6.8v18.7H4.5zM8.2 5.4h7.6v17.1H8.2z",
    "M13.7 12.7a1.1 1.1 0 0 0 0 2.2 1.1 1.1 0 0 0 0-2.2z",
  ],
  garden: ["M12 1.5l6 8h-3.2l5 7h-6.4v6h-2.8v-6H4.2l5-7H6z"],
  lift: ["M3.5 1.5h17v21h-17zM5.8 3.8v16.4h12.4V3.8zM12 5.8l3.9 5H8.1zM12 18.2l-3.9-5h7.8z"],
  charger: [
    "M7.4 1.5h2.4v5h4.4v-5h2.4v5h2.2V12",
    "a6.8 6.8 0 0 1-5.6 6.7v3.8h-2.4v-3.8A6.8 6.8 0 0 1 5.2 12V6.5h2.2z",
  ],
  home: ["M12 2l10.5 9.6h-3.2V21h-5v-6H9.7v6h-5v-9.4H1.5z"],
  no_go: [
    "M12 1.5a10.5 10.5 0 0 1 0 21 10.5 10.5 0 0 1 0-21z",
    "M12 4.1a7.9 7.9 0 0 0-4.7 1.5l11.1 11.1A7.9 7.9 0 0 0 12 4.1z",
    "M5.6 7.3a7.9 7.9 0 0 0 11.1 11.1z",
  ],
  person: [
    "M12 1.5a2.6 2.6 0 0 1 0 5.2 2.6 2.6 0 0 1 0-5.2z",
    "M9.6 7.8h4.8a2.4 2.4 0 0 1 2.3 2.4v5h-2v7.3h-2",
    "v-6.3h-1.4v6.3h-2v-7.3h-2v-5a2.4 2.4 0 0 1 2.3-2.4z",
  ],
  line: ["M8.6 22.5C3.4 18.3 17.8 12 10.4 1.5h3.9C21.5 11.4 7.8 17.4 13.3 22.5z"],
  look: [
    "M1 12Q12-.5 23 12 12 24.5 1 12zM12 7.4a4.6 4.6 0 0 0 0 9.2 4.6 4.6 0 0 0 0-9.2z",
    "M12 9.8a2.2 2.2 0 0 1 0 4.4 2.2 2.2 0 0 1 0-4.4z",
  ],
};

/** The sign's outline in an SVG path's letters; "" for an unknown name. */
export const outline = (name) => (OUTLINES[name] ?? []).join("");

/** A picture of the sign in the colour of the text. */
export function sign(name) {
  const view = { viewBox: `0 0 ${SIDE} ${SIDE}`, class: "sign", "aria-hidden": true };
  const picture = svg("svg", view);
  picture.append(svg("path", { d: outline(name) }));
  return picture;
}

/** Fills the sign on a canvas around a middle, with this side. */
export function fillSign(pen, name, [x, y], side) {
  pen.save();
  pen.translate(x - side / 2, y - side / 2);
  pen.scale(side / SIDE, side / SIDE);
  pen.fill(new Path2D(outline(name)), "evenodd");
  pen.restore();
}
