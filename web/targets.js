// The driver's intent as a pure state machine: hover, dwell, leave, press. Time is injected.

import { ALL, isDrive, isMenu, isPlugin, MENU_FACTOR, REST_MS } from "./intent_times.js";
import { STEP_REPEAT_MS, TAP_MS } from "./intent_times.js";

/**
 * Turns pointer, touch and key events into commands.
 *
 * All times are ms of one monotonic clock. `on` receives:
 * drive(verb, mode, edge) for every command to send, stop(chosen), `chosen` if somebody looked at
 * Stop or pressed it, act(name, since) for a button, `since` when its press or dwell
 * began, tap(verb) when a press was too short to drive, unable() for a refused press,
 * view(dwelling, holding, dwellMs) when either name changed.
 */
export class Targets {
  mode = "continuous";
  /** Drive targets that cannot be held now; a hold on one ends. */
  unable = [];
  #on;
  /** Gaze starts a drive target only while the chair is armed; a press always asks the board. */
  armed = false;
  // Of the driver's profile, which the page takes first:
  #dwellMs;
  #steerMs;
  #buttonMs;
  #graceMs;
  #staleMs;
  // Until the host has said:
  #heartbeatMs = 0;
  #ttlMs = Infinity;
  #freshMs;
  #edge = 0;
  #under = undefined; // target under the pointer, null: none, undefined: not known
  #spent = null; // button that acted and that the gaze has not left yet
  #dwell = null; // {target, since, away, movedAt, leftAt, ms}
  // {target, source, mode, edge, since, provenAt, leftAt, sendAt}
  #hold = null;
  #pressed = null; // button pressed and not released: {target, source, since}
  #restNeeded = true;
  #restSince = null;
  #shown = "null null";

  constructor(on) {
    this.#on = on;
  }

  /** Period of a held command and its time to live on the board, ms; null: unknown. */
  setTimes(heartbeatMs, ttlMs) {
    this.#heartbeatMs = heartbeatMs;
    this.#ttlMs = ttlMs ?? Infinity;
    this.#fresh();
  }

  /** Takes the times of a person's profile (ms). */
  configure(mine) {
    this.#dwellMs = mine.dwell_ms;
    this.#steerMs = mine.steer_dwell_ms;
    this.#buttonMs = mine.button_dwell_ms;
    this.#graceMs = mine.leave_grace_ms;
    this.#staleMs = mine.pointer_stale_ms;
    this.#fresh();
  }

  get holding() {
    return this.#hold !== null;
  }

  /** Changes between "step" and "continuous"; ends every hold. */
  setMode(mode, at) {
    this.mode = mode;
    if (this.#hold) this.stop(at);
  }

  /** The pointer moved, no button down, and is now over `target` (null: none). */
  hover(target, at) {
    const entered = target !== this.#under;
    this.#under = target;
    this.#rest(target, at);
    if (target === null || ![target, ALL].includes(this.#spent)) this.#spent = null;
    if (target === "stop") return entered && this.stop(at, true);
    if (this.#hold) this.#hoverWhileHolding(target, at);
    else this.#hoverIdle(target, at);
    this.#show();
  }

  /** A mouse button, finger or key went down on `target`; `source`: which one. */
  press(target, source, at) {
    this.#dwell = null;
    this.#under = target;
    if (target === "stop") this.stop(at, true);
    else if (isDrive(target)) this.#activate(target, source, at);
    else if (target) this.#pressed = { target, source, since: at };
    this.#show();
  }

  /** The pointer of a press moved and is now over `target`. Leaving ends the press at once. */
  drag(target, source, at) {
    const entered = target !== this.#under;
    this.#under = target;
    if (target === "stop" && entered) this.stop(at, true);
    if (this.#hold?.source === source && this.#hold.target !== target) this.#letGo(at);
    if (this.#pressed?.source === source && this.#pressed.target !== target) this.#pressed = null;
    this.#show();
  }

  /** The contact of a held switch is open, perhaps only for a bounce: nothing proves the press. */
  doubt(source, open, at) {
    if (this.#hold?.source === source) this.#hold.leftAt = open ? at : null;
  }

  /** The button, finger or key was released. */
  release(source, at) {
    const pressed = this.#pressed;
    if (pressed?.source === source) {
      this.#pressed = null;
      this.#act(pressed.target, pressed.since);
    }
    const hold = this.#hold;
    if (hold?.source === source) {
      this.#letGo(at);
      if (hold.mode === "continuous" && at - hold.since < TAP_MS) this.#on.tap(hold.target);
    }
    this.#show();
  }

  /** Stops at once and forgets every hold. */
  stop(at, chosen = false) {
    this.#dwell = this.#hold = this.#pressed = null;
    this.#needRest(at);
    this.#on.stop(chosen);
    this.#show();
  }

  /** As stop(), when the pointer's place is no longer known: page hidden, focus or link lost. */
  cancel(at) {
    this.#under = undefined;
    this.stop(at);
  }

  /** The buttons, or (`all` false) the tiles, were replaced: a gaze on one did not choose it. */
  replaced(at, all = true) {
    if (all || isPlugin(this.#hold?.target)) this.cancel(at);
    this.#dwell = null;
    this.#spent = ALL;
  }

  /** The chair became armed for this page, or no longer is: then every hold ends. */
  setArmed(armed, at) {
    if (armed === this.armed) return;
    this.armed = armed;
    if (!armed && this.#hold) this.stop(at);
  }

  /** Advances the time; call it often (every 25 ms). */
  tick(now) {
    this.#rested(now);
    if (this.#hold) this.#tickHold(now);
    if (this.#dwell) this.#tickDwell(now);
    this.#show();
  }

  #hoverWhileHolding(target, at) {
    const hold = this.#hold;
    if (hold.source !== "gaze") return;
    if (target === hold.target) {
      // Late return (the page stalled): make up for the tick that should have stopped.
      if (this.#gazeOver(at)) return this.#letGo(at);
      hold.provenAt = at;
      hold.leftAt = null;
      this.#dwell = null;
    } else if (hold.mode === "step") {
      this.#letGo(at);
    } else {
      hold.leftAt ??= at;
      this.#steer(target, at);
    }
  }

  /** While moving, a look at another direction needs less time; the old motion ends meanwhile. */
  #steer(target, at) {
    if (this.#dwell && at - this.#dwell.movedAt >= this.#staleMs) this.#dwell = null;
    if (!this.#dwell && this.#gazeOver(at)) return this.#letGo(at);
    if (!isDrive(target)) this.#dwell = null;
    else if (this.#dwell?.target === target) this.#dwell.movedAt = at;
    else this.#dwell = { target, since: at, away: 0, movedAt: at, leftAt: null, ms: this.#steerMs };
    this.#finishDwell(at);
  }

  #hoverIdle(target, at) {
    let dwell = this.#dwell;
    if (dwell && (at - dwell.movedAt >= this.#staleMs || (target && target !== dwell.target))) {
      dwell = this.#dwell = null;
    }
    if (dwell && target === null) {
      dwell.leftAt ??= at;
      return;
    }
    if (dwell) {
      dwell.away += at - (dwell.leftAt ?? at);
      dwell.leftAt = null;
      dwell.movedAt = at;
    } else if (this.#mayDwell(target)) {
      const button = this.#buttonMs * (isMenu(target) ? MENU_FACTOR : 1);
      const ms = isDrive(target) ? this.#dwellMs : button;
      this.#dwell = { target, since: at, away: 0, movedAt: at, leftAt: null, ms };
    }
    this.#finishDwell(at);
  }

  #mayDwell(target) {
    if (target === null || [target, ALL].includes(this.#spent)) return false;
    return !isDrive(target) || (this.armed && !this.#restNeeded && !this.unable.includes(target));
  }

  #finishDwell(now) {
    const { target, since, away, ms, leftAt, movedAt } = this.#dwell ?? {};
    if (!target || leftAt !== null || now - movedAt >= this.#freshMs) return;
    if (now - since - away >= ms) this.#activate(target, "gaze", now, since);
  }

  #activate(target, source, at, since) {
    this.#dwell = null;
    if (!isDrive(target)) return this.#act(target, since);
    if (this.unable.includes(target)) return this.#on.unable();
    const mode = isPlugin(target) ? "continuous" : this.mode;
    const edge = (this.#edge += 1);
    const sendAt = at + this.#heartbeatMs;
    this.#hold = { target, source, mode, edge, since: at, provenAt: at, leftAt: null, sendAt };
    this.#on.drive(target, mode, edge);
  }

  #act(name, since) {
    this.#spent = name;
    this.#on.act(name, since);
  }

  #gazeOver(now) {
    const hold = this.#hold;
    const left = hold.leftAt !== null && now - hold.leftAt >= this.#graceMs;
    return left || now - hold.provenAt >= this.#staleMs;
  }

  #tickHold(now) {
    const hold = this.#hold;
    const gaze = hold.source === "gaze";
    if (this.unable.includes(hold.target)) return this.stop(now);
    if (gaze && hold.mode === "continuous" && this.#gazeOver(now)) return this.#letGo(now);
    if (now < hold.sendAt) return;
    hold.sendAt = Math.max(hold.sendAt + this.#heartbeatMs, now);
    const proven = hold.leftAt === null && (!gaze || now - hold.provenAt < this.#freshMs);
    const wanted = hold.mode === "step" ? now - hold.since < STEP_REPEAT_MS : proven;
    if (wanted) this.#on.drive(hold.target, hold.mode, hold.edge);
  }

  #tickDwell(now) {
    const dwell = this.#dwell;
    const left = dwell.leftAt !== null && now - dwell.leftAt >= this.#graceMs;
    const gone = isDrive(dwell.target) && !this.armed;
    if (left || gone || now - dwell.movedAt >= this.#staleMs) this.#dwell = null;
    else this.#finishDwell(now);
  }

  /** Ends the hold. A step runs to its end by itself; continuous motion stops now. */
  #letGo(at) {
    const { mode } = this.#hold;
    this.#hold = null;
    this.#needRest(at);
    if (mode === "continuous") this.#on.stop(false);
  }

  #fresh() {
    // Heartbeats end early, so that the board's time to live runs out when the pointer is stale.
    this.#freshMs = Math.max(this.#heartbeatMs, this.#staleMs - this.#ttlMs);
  }

  #needRest(at) {
    this.#restNeeded = true;
    this.#restSince = this.#under === undefined || isDrive(this.#under) ? null : at;
  }

  #rest(target, at) {
    this.#rested(at);
    if (isDrive(target)) this.#restSince = null;
    else this.#restSince ??= at;
  }

  #rested(now) {
    if (this.#restSince !== null && now - this.#restSince >= REST_MS) this.#restNeeded = false;
  }

  #show() {
    const dwelling = this.#dwell?.leftAt === null ? this.#dwell.target : null;
    const holding = this.#hold?.target ?? this.#pressed?.target ?? null;
    const shown = `${dwelling} ${holding}`;
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#on.view(dwelling, holding, this.#dwell?.ms);
  }
}
