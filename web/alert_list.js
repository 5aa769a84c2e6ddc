// The alerts on the caretaker's page: list, acknowledge, failed deliveries, test.

import { button, element } from "./elements.js";
import { post } from "./post.js";
import { retryPause } from "./retry.js";

/** The newest; open ones are shown whatever their age. */
const MOST_SHOWN = 12;

/** Newest first. An open one has a button with which this phone's person takes over. */
export class AlertList {
  #root;
  #strings;
  #changed;
  #revision; // that is shown, or being fetched
  #alerts = [];
  #requests = 0; // sent

  /** `changed(open)` receives the alerts that are not acknowledged. */
  constructor(root, strings, changed) {
    this.#root = root;
    this.#strings = strings;
    this.#changed = changed;
  }

  /** The host has this revision of the alerts. */
  update(revision) {
    if (revision === undefined || revision === this.#revision) return;
    this.#revision = revision;
    this.#ask({ cache: "no-store" });
  }

  /** This phone's person has answered the call for help. */
  answerHelp() {
    const help = this.#alerts.findLast(({ kind, state }) => kind === "help" && state !== "over");
    if (help && !help.by) this.#post({ acknowledge: help.number });
  }

  test() {
    // Browsers allow this request only in a press.
    globalThis.Notification?.requestPermission();
    this.#post({ test: true });
  }

  #post(request) {
    this.#ask(post(request));
  }

  /** Answers may overtake each other: only that of the newest request is shown. */
  async #ask(request) {
    const number = (this.#requests += 1);
    let answer = {};
    try {
      answer = await (await fetch("/alerts", request)).json();
    } catch (error) {
      console.warn(`alerts: ${error.message}`);
    }
    if (number !== this.#requests) return;
    if (answer.alerts) this.#show(answer);
    else retryPause().then(() => (this.#revision = null));
  }

  #show({ alerts, routes }) {
    const known = new Set(this.#alerts.map(({ number, count }) => `${number} ${count}`));
    this.#alerts = alerts;
    const open = alerts.filter(({ state }) => state === "open");
    for (const alert of open) {
      if (!known.has(`${alert.number} ${alert.count}`)) this.#notify(alert);
    }
    const list = element("ul");
    const newest = alerts.slice(-MOST_SHOWN);
    const shown = alerts.filter((alert) => open.includes(alert) || newest.includes(alert));
    list.append(...shown.reverse().map((alert) => this.#row(alert)));
    const label = (key) => this.#strings.label(key);
    const note = element("p", "", label(routes.length ? "alert_note" : "alert_no_route"));
    const test = button(label("alert_try"), () => this.test());
    this.#root.replaceChildren(note, test, list);
    this.#changed(open);
  }

  #text(key) {
    return this.#strings.label(key) ?? this.#strings.message(key).text;
  }

  #row({ number, key, at, sentence, detail, count, state, by, deliveries }) {
    const label = (name) => this.#strings.label(name);
    const row = element("li");
    row.dataset.state = state;
    const words = element("p");
    const times = count > 1 ? ` ${count}×` : "";
    words.append(element("b", "", `${this.#text(key)}${times}`));
    const when = new Date(at * 1000).toLocaleString(this.#strings.language);
    words.append(element("small", "", `${when} · ${label(`alert_${state}`)} ${by}`.trim()));
    for (const more of [sentence, detail]) if (more) words.append(element("small", "", more));
    for (const [route, sent] of Object.entries(deliveries)) {
      const result = `${route}: ${label(`alert_${sent.state}`)} ${sent.detail}`;
      words.append(element("small", "", result));
    }
    row.append(words);
    if (state === "open") {
      const take = () => this.#post({ acknowledge: number });
      row.append(button(label("care_answer"), take));
    }
    return row;
  }

  #notify({ number, key, sentence }) {
    if (globalThis.Notification?.permission !== "granted") return;
    try {
      new Notification(this.#text(key), { body: sentence, tag: `alert ${number}` });
    } catch (error) {
      console.warn(`notification: ${error.message}`); // some phones' browsers allow none
    }
  }
}
