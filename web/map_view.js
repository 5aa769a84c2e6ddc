// A map's picture on a canvas, the chair and what people drew on it; taps as metres in the map.

import { fillSign } from "./signs.js";

const CHAIR = "#0b6b99";
const NO_GO = "rgb(200 30 41 / 45%)";
const INK = "#10202b";
const WAY = "#0b6b99";
const DOT = 5;
const ARROW = 14;

export class MapView {
  #canvas;
  #image = null; // the picture, once loaded
  #coming = null; // the newest picture requested
  #place = null; // the picture's place in the map: cell_m, x, y, width, height
  #drawing = { places: [], no_go: [], home: null };
  #draft = { points: [], closed: false };
  #where = null;
  #going = null;

  /** `tapped(x, y)`: metres in the map. */
  constructor(canvas, tapped) {
    this.#canvas = canvas;
    canvas.addEventListener("click", (event) => {
      const point = this.#image && this.#metres(event);
      if (point) tapped(...point);
    });
    // The phone is turned, the window is resized, its tab or its style sheet comes.
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Shows this picture once it has loaded, until then the one before; false: it did not load. */
  async picture(url, place) {
    const image = new Image();
    this.#coming = image;
    image.src = url;
    const loaded = await image.decode().then(
      () => true,
      () => false,
    );
    if (!loaded || image !== this.#coming) return loaded;
    [this.#image, this.#place] = [image, place];
    this.draw();
    return true;
  }

  /** Shows nothing, for another map. */
  clear() {
    this.#image = this.#coming = null;
    this.draw();
  }

  /** The drawn items; `draft`: points being tapped. */
  show(drawing, draft) {
    [this.#drawing, this.#draft] = [drawing, draft];
    this.draw();
  }

  /** The auto motion: `way` and `goal` of the host's `going`, or null. */
  way(going) {
    const on = going && !["arrived", "ended"].includes(going.state) ? going : null;
    const before = JSON.stringify([this.#going?.way, this.#going?.goal]);
    if (JSON.stringify([on?.way, on?.goal]) === before) return;
    this.#going = on;
    this.draw();
  }

  /** The chair: x, y, heading, or null. */
  chair(where) {
    const before = JSON.stringify(this.#where);
    this.#where = where;
    if (JSON.stringify(where) !== before) this.draw();
  }

  /** Canvas pixels per metre, and the corner of the picture. */
  #scale() {
    const { cell_m: cell, width, height } = this.#place;
    const [wide, high] = [this.#canvas.width, this.#canvas.height];
    const pixels = Math.min(wide / width, high / height);
    return {
      pixels: pixels / cell,
      left: (wide - width * pixels) / 2,
      top: (high - height * pixels) / 2,
      wide: width * pixels,
      high: height * pixels,
    };
  }

  #metres(event) {
    const box = this.#canvas.getBoundingClientRect();
    const { pixels, left, top, wide, high } = this.#scale();
    // Until the next frame, a canvas that has just been resized is shown distorted.
    const x = ((event.clientX - box.left) * this.#canvas.width) / box.width - left;
    const y = ((event.clientY - box.top) * this.#canvas.height) / box.height - top;
    if (x < 0 || y < 0 || x > wide || y > high) return null;
    return [this.#place.x + x / pixels, this.#place.y + (high - y) / pixels];
  }

  /** Draws it again, in the canvas's present size. */
  draw() {
    const canvas = this.#canvas;
    const ratio = globalThis.devicePixelRatio ?? 1;
    const size = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, canvas.width, canvas.height);
    if (!this.#image) return;
    const { pixels, left, top, wide, high } = this.#scale();
    pen.imageSmoothingEnabled = false;
    pen.drawImage(this.#image, left, top, wide, high);
    const at = (x, y) => {
      return [left + (x - this.#place.x) * pixels, top + high - (y - this.#place.y) * pixels];
    };
    for (const { corners } of this.#drawing.no_go) this.#area(pen, corners, at, ratio);
    const { home } = this.#drawing;
    if (home) this.#spot(pen, at(home.x, home.y), home.heading, "home", "", ratio);
    for (const { x, y, heading, icon, name } of this.#drawing.places) {
      this.#spot(pen, at(x, y), heading, icon, name, ratio);
    }
    this.#area(pen, this.#draft.points, at, ratio, this.#draft.closed);
    if (this.#going) this.#path(pen, this.#going, at, ratio);
    if (this.#where) this.#arrow(pen, at(this.#where.x, this.#where.y), this.#where.heading, ratio);
  }

  #area(pen, corners, at, ratio, closed = true) {
    if (corners.length === 0) return;
    pen.beginPath();
    for (const [x, y] of corners) pen.lineTo(...at(x, y));
    pen.fillStyle = NO_GO;
    pen.strokeStyle = INK;
    pen.lineWidth = ratio;
    if (closed) pen.fill();
    pen.stroke();
    for (const [x, y] of closed ? [] : corners) this.#dot(pen, at(x, y), ratio);
  }

  #path(pen, { way, goal }, at, ratio) {
    pen.beginPath();
    for (const [x, y] of way ?? []) pen.lineTo(...at(x, y));
    pen.strokeStyle = WAY;
    pen.lineWidth = 3 * ratio;
    pen.stroke();
    this.#dot(pen, at(goal.x, goal.y), ratio);
  }

  #dot(pen, [x, y], ratio) {
    pen.beginPath();
    pen.arc(x, y, DOT * ratio, 0, 2 * Math.PI);
    pen.fillStyle = INK;
    pen.fill();
  }

  #spot(pen, [x, y], heading, sign, name, ratio) {
    this.#dot(pen, [x, y], ratio);
    const turned = (-heading * Math.PI) / 180;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + ARROW * ratio * Math.cos(turned), y + ARROW * ratio * Math.sin(turned));
    pen.strokeStyle = INK;
    pen.lineWidth = 3 * ratio;
    pen.stroke();
    pen.font = `${13 * ratio}px sans-serif`;
    pen.textAlign = "center";
    pen.fillStyle = INK;
    const [side, above] = [16 * ratio, y - 10 * ratio];
    const wide = name ? pen.measureText(name).width + 3 * ratio : 0;
    fillSign(pen, sign, [x - wide / 2, above - side / 3], side);
    pen.fillText(name, x + (wide ? side + 3 * ratio : 0) / 2, above);
  }

  #arrow(pen, [x, y], heading, ratio) {
    pen.save();
    pen.translate(x, y);
    pen.rotate((-heading * Math.PI) / 180);
    pen.beginPath();
    for (const [ahead, aside] of [[12, 0], [-8, 7], [-4, 0], [-8, -7]]) {
      pen.lineTo(ahead * ratio, aside * ratio);
    }
    pen.closePath();
    pen.fillStyle = CHAIR;
    pen.strokeStyle = "#fff";
    pen.lineWidth = 1.5 * ratio;
    pen.fill();
    pen.stroke();
    pen.restore();
  }
}
