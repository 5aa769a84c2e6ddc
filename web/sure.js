// A button that asks for confirmation and acts at a second press; a double tap counts as one.

const SURE_MS = 5000;
/** A second press sooner than this is still the first. */
const TAP_MS = 500;

/** `act()` at the second press within 5 s, then it asks again. The button keeps its size. */
export function sureButton(text, question, act) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "sure";
  let asks = false;
  let timer = 0;
  let pressedMs = -Infinity;
  const show = (asking) => {
    clearTimeout(timer);
    asks = asking;
    button.textContent = asks ? question : text;
    if (asks) timer = setTimeout(() => show(false), SURE_MS);
  };
  show(false);
  button.addEventListener("click", () => {
    const passed = performance.now() - pressedMs;
    if (passed < TAP_MS) return;
    pressedMs = performance.now();
    const sure = asks && passed < SURE_MS;
    show(!sure);
    if (sure) act(button);
  });
  button.addEventListener("unsure", () => show(false));
  return button;
}

/** What these buttons would act on is another thing now: they ask again. */
export function unsure(root) {
  for (const button of root.querySelectorAll(".sure")) button.dispatchEvent(new Event("unsure"));
}
