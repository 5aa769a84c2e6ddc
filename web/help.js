// The button "Hulp": whether help was requested, who receives the call, who comes.

import { byId, setData, setText } from "./dom.js";

/** Of the host's state: `call`, `coming`, `heard`. */
export function showHelp({ call = false, coming = false, heard }, strings) {
  setData("call", call);
  setData("coming", coming);
  const button = byId("help");
  if (button.ariaPressed !== String(call)) button.ariaPressed = call;
  setText("help-label", strings.label(coming ? "coming" : call ? "help_asked" : "help"));
  const hears = call && heard ? "help_waits" : heard ? "help_heard" : "help_unheard";
  setText("help-state", coming ? "" : strings.label(hears));
}
