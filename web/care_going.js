// An auto motion on the caretaker's page: goal, path, why it stands; a pause.
// It comes last, and keeps its place: nothing moves under a finger.

import { ARRIVED, goingTexts } from "./going.js";
import { atTouch } from "./held_button.js";
import { MapPicture } from "./map_picture.js";
import { MapView } from "./map_view.js";

/** The part, in `root`. `on` receives pause(), tone(shape). Throws when its texts do not load. */
export async function careGoing(root, strings, on) {
  return new CareGoing(root, await goingTexts(strings), on);
}

class CareGoing {
  #texts;
  #on;
  #box = document.createElement("div");
  #line = document.createElement("p");
  #canvas = document.createElement("canvas");
  #pause = document.createElement("button");
  #view;
  #picture;
  #state = "";

  constructor(root, texts, on) {
    [this.#texts, this.#on] = [texts, on];
    [this.#box.id, this.#canvas.id, this.#line.dir] = ["going", "going-map", "auto"];
    this.#line.setAttribute("role", "status");
    this.#canvas.setAttribute("aria-hidden", "true");
    this.#pause.type = "button";
    this.#pause.textContent = texts.label("going_pause");
    atTouch(this.#pause, on.pause);
    this.#box.append(this.#line, this.#canvas, this.#pause);
    root.append(this.#box);
    this.#view = new MapView(this.#canvas, () => {});
    this.#picture = new MapPicture(this.#view);
  }

  /** Takes `going` and `where` of the host's state. */
  update(going, where, rides) {
    this.#box.classList.toggle("shown", Boolean(going));
    this.#pause.classList.toggle("shown", rides);
    if (!going) return;
    const { text, do: advice } = this.#texts.status(going);
    const line = [text, rides ? this.#texts.left(going) : advice].filter(Boolean).join(" ");
    if (this.#line.textContent !== line) this.#line.textContent = line;
    const before = this.#state;
    this.#state = going.state;
    if (going.state === "arrived" && before && before !== "arrived") this.#on.tone(ARRIVED);
    const map = going.goal?.map || this.#picture.map;
    const here = where?.map === map ? where : null;
    this.#picture.show(map, here?.version);
    this.#view.way(going);
    this.#view.chair(here);
  }
}
