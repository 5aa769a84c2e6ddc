// How often the caretaker's page repeats a pressed button's message, in ms: from `welcome`.
// Until then nothing is sent.

export let heartbeatMs = 0;

export function setHeartbeat(ms) {
  heartbeatMs = ms;
}
