// Passes browser events (pointer, touch, key, focus) to the intent machine; decides nothing.

const KEYS = {
  ArrowUp: "forward",
  ArrowDown: "backward",
  ArrowLeft: "left",
  ArrowRight: "right",
  " ": "stop",
  Escape: "stop",
};
/** Moves this shortly before a press belong to it: a click by gaze jumps there and presses. */
const OWN_MOVE_MS = 60;
const RECENT_MS = 1500;

/** Detects a pointer that stands still, which the browser repeats: that proves no look. */
export function standstill() {
  let last = "";
  return ({ clientX: x, clientY: y }) => last === (last = `${x} ${y}`);
}

/** Detects clicks of a pointer that never moves in between: gaze control that only clicks. */
class ClickOnly {
  #moves = [];

  moved(at) {
    this.#moves = this.#moves.filter((move) => at - move < RECENT_MS);
    this.#moves.push(at);
  }

  /** True when no pointer moved before the press that happens now. */
  pressed(at) {
    return !this.#moves.some((move) => at - move < RECENT_MS && at - move > OWN_MOVE_MS);
  }
}

/**
 * Listens on the page for its whole life.
 *
 * `targets` is a Targets, `hits` a HitMap, `shown(name)`: whether a target can be chosen now.
 * `away()` is called when the page loses its person: hidden, without focus, closed.
 * `pressed(alone)` is called at every press of the pointer, true when no movement led to it. Event
 * times are the browser's own stamps: a backlog after a stall proves nothing fresh.
 */
export function listen(targets, hits, { shown, away, pressed }) {
  let current = null;
  const clicks = new ClickOnly();
  const still = standstill();
  const stampOf = (event) => Math.min(event.timeStamp, performance.now());
  const find = (event) => (current = hits.at(event.clientX, event.clientY, current));
  const source = (event) => `pointer ${event.pointerId}`;
  const cancel = () => {
    current = null;
    targets.cancel(performance.now());
  };
  const leave = () => {
    cancel();
    away();
  };

  addEventListener("pointermove", (event) => {
    const at = stampOf(event);
    // A driver who scans without gaze: looking does nothing.
    if (event.defaultPrevented) return;
    // While another button of the mouse is down, a move reports that the left one came up.
    if (!(event.buttons & 1)) targets.release(source(event), at);
    if (event.buttons) return targets.drag(find(event), source(event), at);
    if (still(event)) return;
    clicks.moved(at);
    targets.hover(find(event), at);
  });
  addEventListener("pointerdown", (event) => {
    // Prevented: it was the switch.
    if (event.button !== 0 || event.defaultPrevented) return;
    const at = stampOf(event);
    // Ensures that we get the release when the pointer leaves the window with the button down.
    document.body.setPointerCapture(event.pointerId);
    pressed(event.pointerType === "mouse" && clicks.pressed(at));
    targets.press(find(event), source(event), at);
  });
  // Only the keyboard moves the keyboard's focus.
  addEventListener("mousedown", (event) => event.preventDefault());
  addEventListener("pointerup", (event) => targets.release(source(event), stampOf(event)));
  addEventListener("pointercancel", cancel);
  addEventListener("contextmenu", (event) => event.preventDefault());
  // A click without a pointer comes from assistive technology: a press and its release.
  addEventListener("click", (event) => {
    const name = event.target.closest?.(".target")?.id;
    if (event.detail !== 0 || !name) return;
    targets.press(name, "click", stampOf(event));
    targets.release("click", stampOf(event));
  });

  // A key is known by its place: what it is called changes with Shift and NumLock.
  // Enter is the key of the target that has the keyboard's focus, else of "Rijden aan".
  const named = (event) =>
    event.key === "Enter" ? (event.target.closest?.(".target")?.id ?? "arm") : KEYS[event.key];
  addEventListener("keydown", (event) => {
    // macOS reports no release while it is down.
    if (event.key === "Meta") return cancel();
    const name = named(event);
    if (!name || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    if (event.repeat || !shown(name)) return;
    targets.press(name, `key ${event.code}`, stampOf(event));
  });
  addEventListener("keyup", (event) => {
    // The browser would add its own click.
    if (named(event)) event.preventDefault();
    targets.release(`key ${event.code}`, stampOf(event));
  });

  addEventListener("blur", leave);
  addEventListener("pagehide", leave);
  document.addEventListener("freeze", leave);
  document.addEventListener("visibilitychange", () => document.hidden && leave());
  document.documentElement.addEventListener("pointerleave", ({ pointerType: kind }) => {
    // A lifted finger or stylus "leaves" too, after its release. What a stylus over the page holds
    // or dwells on ends; what it has tapped goes on.
    if (kind === "mouse" || (kind === "pen" && targets.holding)) cancel();
    else if (kind === "pen") targets.hover((current = null), performance.now());
  });
}
