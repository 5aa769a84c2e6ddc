// Browser events (pointer, touch, key, focus) to the intent machine; nothing is decided here.

const KEYS = {
  ArrowUp: "forward",
  ArrowDown: "backward",
  ArrowLeft: "left",
  ArrowRight: "right",
  " ": "stop",
  Enter: "arm",
};

/**
 * Listens on the page for its whole life.
 *
 * `targets` is a Targets, `hits` a HitMap, `enabled(name)` tells whether a key's target exists.
 * Event times are the browser's own stamps: a backlog after a stall proves nothing fresh.
 */
export function listen(targets, hits, enabled) {
  let current = null;
  let last = { x: NaN, y: NaN };
  const stampOf = (event) => Math.min(event.timeStamp, performance.now());
  const find = (event) => (current = hits.at(event.clientX, event.clientY, current));
  const source = (event) => `pointer ${event.pointerId}`;
  const cancel = () => {
    current = null;
    targets.cancel(performance.now());
  };

  addEventListener("pointermove", (event) => {
    const at = stampOf(event);
    if (event.buttons !== 0) return targets.drag(find(event), source(event), at);
    // The browser repeats a pointer that stands still: no proof of anyone looking.
    if (event.clientX === last.x && event.clientY === last.y) return;
    last = { x: event.clientX, y: event.clientY };
    targets.hover(find(event), at);
  });
  addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.target.closest("a")) return;
    // Keeps the release ours when the pointer leaves the window with the button down.
    document.body.setPointerCapture(event.pointerId);
    targets.press(find(event), source(event), stampOf(event));
  });
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

  addEventListener("keydown", (event) => {
    const name = KEYS[event.key];
    if (!name || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest?.("a") && event.key === "Enter") return;
    event.preventDefault();
    if (event.repeat || !enabled(name)) return;
    targets.press(name, `key ${event.key}`, stampOf(event));
  });
  addEventListener("keyup", (event) => targets.release(`key ${event.key}`, stampOf(event)));

  addEventListener("blur", cancel);
  addEventListener("pagehide", cancel);
  document.addEventListener("freeze", cancel);
  document.addEventListener("visibilitychange", () => document.hidden && cancel());
  document.documentElement.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") cancel(); // a lifted finger "leaves" too: that is a release
  });
}
