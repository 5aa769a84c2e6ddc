// The control socket: fresh tokens, heartbeat, whether the link is alive and this page accepted.

import { Wire } from "./wire.js";

const BEAT_MS = 100;
/** No message from the host for this long: the link counts as lost. */
const LOST_MS = 500;
/** No message for this long: reconnect. */
const SILENCE_MS = 2000;
/** More than this waiting to be sent: only stops are added to it. */
const BACKLOG_BYTES = 512;

/** Messages that are always sent, whatever is queued before them. */
const ALWAYS = ["stop", "disarm", "emergency", "release"];
const REVOKED = 4001;
const PAIR = "/pair";

/**
 * Talks to `/ws/control`.
 *
 * `on` receives message(object) for every message, link(alive) when that changed, closed() when a
 * connection has ended. A page that is not, or no longer, paired goes to the pairing page by
 * itself.
 */
export class ControlSocket {
  #wire;
  #on;
  /** A token older than this proves nothing to the host; set by the host. */
  #tokenMs = 0;
  /** {token, at}: recent tokens that were delayed less than all later ones. */
  #tokens = [];
  #lastMs = 0;
  #beatAtMs = 0;
  #alive = false;
  #welcomed = false;
  /** Stops that this connection has sent. */
  #stops = 0;

  constructor(on) {
    this.#on = on;
    this.#wire = new Wire("/ws/control", SILENCE_MS, {
      message: (data) => this.#receive(JSON.parse(data)),
      closed: (code) => this.#close(code),
    });
  }

  /** True while a command can be expected to arrive. */
  get alive() {
    return this.#alive;
  }

  /** Time since the last message from the host, ms. */
  ageMs(now) {
    return now - this.#lastMs;
  }

  /** Sends {"k": kind, ...}; false when it was not, the number of a stop. Never queues. */
  send(kind, fields) {
    const held = !this.#alive || this.#wire.waiting > BACKLOG_BYTES;
    if (held && !ALWAYS.includes(kind)) return false;
    const sent = this.#wire.send(JSON.stringify({ k: kind, ...fields }));
    return sent && (kind !== "stop" || (this.#stops += 1));
  }

  /** A message that proves its time: by the host's clock and the ms passed since. */
  sendFresh(kind, fields) {
    const now = performance.now();
    this.#forget(now);
    const [best] = this.#tokens;
    if (!best) return false;
    return this.send(kind, { ...fields, token: best.token, since: Math.floor(now - best.at) });
  }

  tick(now) {
    this.#wire.tick(now);
    if (this.#alive && this.ageMs(now) > LOST_MS) this.#setAlive(false);
    if (now < this.#beatAtMs) return;
    this.#beatAtMs = now + BEAT_MS;
    this.sendFresh("hb");
  }

  #receive(message) {
    this.#lastMs = performance.now();
    if (message.k === "welcome") {
      this.#welcomed = true;
      this.#tokenMs = message.token_ms;
    }
    if (message.token !== undefined) this.#keep(message.token, this.#lastMs);
    this.#on.message(message);
    if (this.#tokens.length > 0) this.#setAlive(true);
  }

  /** The first of #tokens is always the least delayed one. */
  #keep(token, at) {
    this.#forget(at);
    while (this.#tokens.length) {
      const last = this.#tokens.at(-1);
      if (token - at < last.token - last.at) break;
      this.#tokens.pop();
    }
    this.#tokens.push({ token, at });
  }

  #forget(now) {
    const kept = this.#tokens;
    while (kept.length && now - kept[0].at > this.#tokenMs) kept.shift();
  }

  #close(code) {
    this.#tokens.length = 0;
    this.#stops = 0;
    this.#on.closed();
    this.#setAlive(false);
    if (code === REVOKED) location.assign(PAIR);
    else if (!this.#welcomed) this.#askWhoWeAre();
    this.#welcomed = false;
  }

  /** Finds out why a handshake was refused, which the browser does not report. */
  async #askWhoWeAre() {
    try {
      const answer = await fetch("/me");
      if (answer.status === 401) location.assign(PAIR);
    } catch {
      // The host does not answer at all: the wire tries again.
    }
  }

  #setAlive(alive) {
    if (alive === this.#alive) return;
    this.#alive = alive;
    this.#on.link(alive);
  }
}
