// How often the caretaker's page repeats what somebody holds, in ms: the host says it in `welcome`.

export let heartbeatMs = 50;

export function setHeartbeat(ms) {
  heartbeatMs = ms;
}
