// The button "Hulp": whether help was requested, who receives the call, who comes.

import { byId, setData, setText } from "./dom.js";

/** A press this soon after a button's label changed is meant for the label before. */
export const WORDS_MS = 500;
/** What the button's label shows, and since when. */
let called = false;
let calledMs = -WORDS_MS;

/** Of the host's state: `call`, `coming`, `heard`. */
export function showHelp({ call = false, coming = false, heard }, strings) {
  if (called !== (call || coming)) [called, calledMs] = [!called, performance.now()];
  setData("call", call);
  setData("coming", coming);
  const button = byId("help");
  if (button.ariaPressed !== String(call)) button.ariaPressed = call;
  setText("help-label", strings.label(coming ? "coming" : call ? "help_asked" : "help"));
  const hears = call && heard ? "help_waits" : heard ? "help_heard" : "help_unheard";
  setText("help-state", coming ? "" : strings.label(hears));
}

/** A press that began at `since`, at that label; `send(on)`: help is needed. Two taps are one. */
export const pressHelp = (send) => (since) =>
  since < calledMs || performance.now() - calledMs < WORDS_MS || send(!called);
