// The control socket: token echo, heartbeat, and whether the link is alive.

import { Wire } from "./wire.js";

const BEAT_MS = 100;
/** No message from the host for this long: the link counts as lost. */
const LOST_MS = 500;
/** No message for this long: the connection is given up and made anew. */
const SILENCE_MS = 2000;
/** More than this waiting to be sent: only stops are added to it. */
const BACKLOG_BYTES = 512;

/** Messages that always go out, whatever waits before them. */
const ALWAYS = ["stop", "disarm", "emergency"];

/**
 * Talks to `/ws/control`.
 *
 * `on` receives message(object) for every message, link(alive) when that changed.
 */
export class ControlSocket {
  #wire;
  #on;
  #token = null;
  #heardMs = 0;
  #beatAtMs = 0;
  #alive = false;

  constructor(on) {
    this.#on = on;
    this.#wire = new Wire("/ws/control", SILENCE_MS, {
      message: (data) => this.#receive(JSON.parse(data)),
      closed: () => this.#close(),
    });
  }

  /** True while a command can be expected to arrive. */
  get alive() {
    return this.#alive;
  }

  /** Time since the host was last heard, ms. */
  ageMs(now) {
    return now - this.#heardMs;
  }

  /** Sends {"k": kind, ...}; motion and heartbeats carry the newest token. Never queues. */
  send(kind, fields = {}) {
    if (!ALWAYS.includes(kind) && (!this.#alive || this.#wire.waiting > BACKLOG_BYTES)) return;
    this.#wire.send(JSON.stringify({ k: kind, ...fields }));
  }

  /** A message that proves it answers the host's newest token. */
  sendFresh(kind, fields = {}) {
    this.send(kind, { ...fields, token: this.#token });
  }

  tick(now) {
    this.#wire.tick(now);
    if (this.#alive && this.ageMs(now) > LOST_MS) this.#setAlive(false);
    if (now < this.#beatAtMs) return;
    this.#beatAtMs = now + BEAT_MS;
    this.sendFresh("hb");
  }

  #receive(message) {
    this.#heardMs = performance.now();
    if (message.token !== undefined) this.#token = message.token;
    this.#on.message(message);
    if (this.#token !== null) this.#setAlive(true);
  }

  #close() {
    this.#token = null;
    this.#setAlive(false);
  }

  #setAlive(alive) {
    if (alive === this.#alive) return;
    this.#alive = alive;
    this.#on.link(alive);
  }
}
