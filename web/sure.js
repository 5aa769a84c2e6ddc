// A button that asks for confirmation and acts at a second press; a double tap counts as one.

const SURE_MS = 5000;
/** A second press sooner than this is still the first. */
const TAP_MS = 500;

/** `act()` at the second press within 5 s. The button keeps its size. */
export function sureButton(text, question, act) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "sure";
  button.textContent = text;
  let asked = -Infinity;
  button.addEventListener("click", () => {
    const passed = performance.now() - asked;
    if (passed < TAP_MS) return;
    if (passed < SURE_MS) return act(button);
    asked = performance.now();
    button.textContent = question;
    setTimeout(() => (button.textContent = text), SURE_MS);
  });
  return button;
}
