// Keeps the tablet's screen on while the page is visible, where the browser can.

/** Requests the wake lock now and after each return to the page. */
export function keepAwake() {
  // Not available over plain http, except on loopback.
  if (!navigator.wakeLock) return;
  const ask = () => {
    if (document.hidden) return;
    navigator.wakeLock.request("screen").catch((error) => {
      console.warn(`the screen may switch itself off: ${error.message}`);
    });
  };
  document.addEventListener("visibilitychange", ask);
  ask();
}
