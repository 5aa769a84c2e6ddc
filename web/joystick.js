// An on-screen joystick: proportional, springs back.
// It drives only while touched, while a key is pressed, or while a gamepad's stick is out of
// its middle.

import { heartbeatMs } from "./heartbeat.js";

/** Dead zone, as a fraction. */
const DEAD = 0.1;
/** What an arrow key pushes, of 1000. */
const KEY_PERMILLE = 500;
const KEYS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };

/** Permille forward and left, for a touch at -1..1 (right, down), with the dead zone removed. */
export function push(x, y) {
  const far = Math.hypot(x, y);
  if (far < DEAD) return { linear: 0, turn: 0 };
  const strength = (Math.min(1, far) - DEAD) / (1 - DEAD) / far;
  return { linear: Math.round(-1000 * y * strength), turn: Math.round(-1000 * x * strength) };
}

/**
 * The pad. Its position is read once, at the grab: a page that moves under a finger does not change
 * the finger's meaning. `on` receives drive(linear, turn, fresh) at once and at every
 * heartbeat while held, `fresh` for a new press, and stop() when it ends for whatever reason.
 */
export class Joystick {
  enabled = false;
  #pad;
  #knob;
  #on;
  #pointer = null;
  #grab = null; // where the pad lay when it was grabbed: {x, y} of its middle, radius (px)
  #keys = new Map(); // of held keys: place on the keyboard, what it pushes
  #byGamepad = false;
  #now = null; // {linear, turn} while pressed
  #sendAt = 0;

  constructor(pad, knob, on) {
    this.#pad = pad;
    this.#knob = knob;
    this.#on = on;
    pad.addEventListener("pointerdown", (event) => this.#touch(event));
    pad.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      pad.addEventListener(end, (event) => event.pointerId === this.#pointer && this.end());
    }
    // The screen was rotated or zoomed: the finger's meaning is no longer known.
    for (const screen of [window, visualViewport]) {
      screen.addEventListener("resize", () => this.#pointer !== null && this.end());
    }
    addEventListener("keydown", (event) => this.#key(event, true));
    addEventListener("keyup", (event) => this.#key(event, false));
  }

  /**
   * A gamepad's stick leans to {x, y}, -1..1 right and down, dead zone and curve applied;
   * `fresh` begins a press. False: that press does not live, or another hand has the joystick.
   */
  moveTo({ x, y }, fresh) {
    if (!this.enabled || fresh === this.#byGamepad || (fresh && this.#now !== null)) return false;
    this.#byGamepad = true;
    this.#push({ linear: Math.round(-1000 * y), turn: Math.round(-1000 * x) }, fresh);
    this.#show(x, y);
    return true;
  }

  /** That stick was released, or is gone. */
  release() {
    if (this.#byGamepad) this.end();
  }

  /** Springs back. */
  end() {
    if (this.#now === null) return;
    this.#now = this.#pointer = null;
    this.#byGamepad = false;
    this.#keys.clear();
    this.#show(0, 0);
    this.#on.stop();
  }

  tick(now) {
    if (this.#now === null) return;
    if (!this.enabled) return this.end();
    if (now < this.#sendAt) return;
    this.#sendAt = now + heartbeatMs;
    this.#on.drive(this.#now.linear, this.#now.turn, false);
  }

  #touch(event) {
    event.preventDefault();
    if (!this.enabled || event.button !== 0 || this.#now !== null) return;
    this.#pad.setPointerCapture(event.pointerId);
    this.#pointer = event.pointerId;
    const { left, top, width, height } = this.#pad.getBoundingClientRect();
    this.#grab = { x: left + width / 2, y: top + height / 2, radius: width / 2 };
    this.#place(event, true);
  }

  #move(event) {
    if (event.pointerId !== this.#pointer) return;
    // The release went elsewhere, or another button of the mouse is still down.
    if ((event.buttons & 1) === 0) this.end();
    else this.#place(event, false);
  }

  #place(event, fresh) {
    const x = (event.clientX - this.#grab.x) / this.#grab.radius;
    const y = (event.clientY - this.#grab.y) / this.#grab.radius;
    const far = Math.max(1, Math.hypot(x, y));
    this.#show(x / far, y / far);
    this.#push(push(x, y), fresh);
  }

  #key(event, down) {
    // macOS reports no release while this key is down.
    if (down && event.key === "Meta" && this.#keys.size > 0) return this.end();
    // By its place: what a key is called changes with Shift and NumLock.
    const held = this.#keys.has(event.code);
    const typing = event.target.closest?.("input, select, textarea");
    const others = typing || event.ctrlKey || event.altKey || event.metaKey;
    // A held key stays the joystick's until it comes up, wherever the focus has gone meanwhile.
    if (!held && (!KEYS[event.key] || others || !down)) return;
    event.preventDefault();
    const busy = this.#pointer !== null || this.#byGamepad;
    if (down && (held || event.repeat || !this.enabled || busy)) return;
    const fresh = this.#now === null;
    if (down) this.#keys.set(event.code, KEYS[event.key]);
    else this.#keys.delete(event.code);
    if (this.#keys.size === 0) return this.end();
    let [linear, turn] = [0, 0];
    // Two keys for one direction (the keypad has one, too) push as one.
    for (const [ahead, left] of new Set(this.#keys.values())) {
      linear += ahead;
      turn += left;
    }
    this.#show(-turn / 2, -linear / 2);
    this.#push({ linear: linear * KEY_PERMILLE, turn: turn * KEY_PERMILLE }, fresh);
  }

  #push(out, fresh) {
    this.#now = out;
    if (!fresh) return; // the next heartbeat sends it: newest wins
    this.#sendAt = performance.now() + heartbeatMs;
    this.#on.drive(out.linear, out.turn, true);
  }

  #show(x, y) {
    this.#knob.style.setProperty("transform", `translate(${50 * x}%, ${50 * y}%)`);
    this.#pad.classList.toggle("held", this.#now !== null || x !== 0 || y !== 0);
  }
}
