// One WebSocket that reconnects: back-off, connect time-out, silence time-out.

/**
 * Waits before each new attempt; the last one repeats. A daemon that was killed is back within 1 to
 * 3 s. Browsers themselves delay attempts of a page that fails more often.
 */
const RETRIES_MS = [250, 500, 500, 500, 500, 500, 1000, 2000];
const CONNECT_MS = 3000;

/**
 * A reconnecting WebSocket without its own timers: its owner calls tick(now).
 *
 * `path` is on this page's host; `silenceMs` without a message counts as a dead connection;
 * `on` receives message(data) and closed(code).
 */
export class Wire {
  #path;
  #silenceMs;
  #on;
  #socket = null;
  /** Start of the attempt, then the last message. */
  #sinceMs = 0;
  /** Attempts since the last message. */
  #failed = 0;
  #retryAtMs = 0;

  constructor(path, silenceMs, on) {
    this.#path = path;
    this.#silenceMs = silenceMs;
    this.#on = on;
  }

  /** True while messages can be sent. */
  get open() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Bytes handed to the browser and not yet on the network. */
  get waiting() {
    return this.#socket?.bufferedAmount ?? 0;
  }

  /** Sends text; false when the wire is not open (nothing is kept for later). */
  send(text) {
    if (!this.open) return false;
    this.#socket.send(text);
    return true;
  }

  /** Connects, drops a silent connection, retries. `now`: performance.now(). */
  tick(now) {
    if (this.#socket === null) {
      if (now >= this.#retryAtMs) this.#connect(now);
      return;
    }
    const limitMs = this.open ? this.#silenceMs : CONNECT_MS;
    if (now - this.#sinceMs > limitMs) this.#drop(now);
  }

  #connect(now) {
    const socket = new WebSocket(location.origin.replace("http", "ws") + this.#path);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#sinceMs = now;
    socket.onopen = () => (this.#sinceMs = performance.now());
    socket.onmessage = (event) => {
      this.#sinceMs = performance.now();
      this.#failed = 0;
      this.#on.message(event.data);
    };
    socket.onclose = (event) => this.#drop(performance.now(), event.code);
  }

  #drop(now, code) {
    const socket = this.#socket;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.#socket = null;
    this.#retryAtMs = now + (RETRIES_MS[this.#failed] ?? RETRIES_MS.at(-1));
    this.#failed += 1;
    this.#on.closed?.(code);
  }
}
