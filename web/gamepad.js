// A gamepad or joystick at the caretaker's device: polled, with a dead zone, a curve, a centre.

/** Dead zone, as a fraction: worn sticks do not return exactly to their middle. */
const DEAD = 0.2;
/** What a held direction button pushes, of 1. */
const BUTTON = 0.5;
/**
 * Buttons of the standard layout (others do not define their buttons): the four for the right hand
 * stop; up, down, left, right.
 */
const STOPS = [0, 1, 2, 3];
const DIRECTIONS = [
  [12, 0, -1],
  [13, 0, 1],
  [14, -1, 0],
  [15, 1, 0],
];

/** The push, as fraction and direction, at a stick's place (right and down -1..1); null: none. */
export function shaped(x, y) {
  const far = Math.hypot(x, y);
  if (!(far >= DEAD)) return null; // not a number either
  const out = (Math.min(1, far) - DEAD) / (1 - DEAD);
  // Fine near the middle, full at the rim.
  const strength = (0.4 * out + 0.6 * out ** 3) / far;
  return { x: x * strength, y: y * strength };
}

/** The request from this pad: {x, y, stop}; x and y 0: nothing. */
export function requested({ axes, buttons, mapping }) {
  const pressed = (at) => Boolean(buttons[at]?.pressed);
  const standard = mapping === "standard";
  let [x, y] = [0, 0];
  if (standard) {
    for (const [at, right, down] of DIRECTIONS) {
      if (!pressed(at)) continue;
      x += BUTTON * right;
      y += BUTTON * down;
    }
  }
  const stick = shaped(axes[0] ?? 0, axes[1] ?? 0);
  return { ...(stick ?? { x, y }), stop: standard && STOPS.some(pressed) };
}

/**
 * One hand at one of the connected pads: `on` receives moveTo(place, fresh), which returns whether
 * that press lives, place {x, y} of -1..1 right and down; letGo(), and stop() for its stop buttons.
 *
 * A pad must have been seen in its middle before it can press: since it was connected, since
 * driving from here became possible, since its last press ended in whatever way.
 */
export class Gamepads {
  #on;
  #centred = new Set(); // pads by number and name
  #held = null; // the pad that presses
  #stopping = new Set();

  constructor(on) {
    this.#on = on;
  }

  /** `pads` from navigator.getGamepads(); `ready`: they may drive, and the page is visible. */
  look(pads, ready) {
    const here = pads.filter((pad) => pad?.connected && pad.axes.length >= 2);
    const names = new Map(here.map((pad) => [`${pad.index} ${pad.id}`, requested(pad)]));
    for (const name of [...this.#centred]) {
      if (!ready || !names.has(name)) this.#centred.delete(name);
    }
    if (this.#held !== null && (!ready || !names.has(this.#held))) this.#end();
    for (const [name, { x, y, stop }] of names) {
      const again = this.#stopping.has(name);
      this.#stopping[stop ? "add" : "delete"](name);
      if (stop) this.#centred.delete(name);
      if (stop && !again) this.#on.stop();
      if (stop && this.#held === name) this.#held = null;
      if (!ready || stop) continue;
      const middle = x === 0 && y === 0;
      if (middle) {
        if (this.#held === name) this.#end();
        this.#centred.add(name);
      } else if (this.#held === name) {
        if (!this.#on.moveTo({ x, y }, false)) this.#held = null;
      } else if (this.#centred.delete(name) && this.#held === null) {
        if (this.#on.moveTo({ x, y }, true)) this.#held = name;
      }
    }
  }

  #end() {
    this.#held = null;
    this.#on.letGo();
  }
}
