// How often the caretaker's page repeats a pressed button's message, in ms: from `welcome`.

export let heartbeatMs = 50;

export function setHeartbeat(ms) {
  heartbeatMs = ms;
}
