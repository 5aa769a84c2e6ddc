// Names and problems of plug-ins as text; the plug-ins' own texts are never trusted.

import { HOME, tableOf } from "./strings.js";

/** Longest name and icon, in characters: what fits on a tile. */
const NAME = 20;
const ICON = 4;
/** The time of the next try is shown in steps of this many seconds, so that it changes less. */
const STEP_S = 5;
const MS = 1000;
/** Problems that need somebody; all others are retried automatically. */
const FOR_PEOPLE = ["plugin_missing", "plugin_setting"];

/** The first characters of others' text. */
export const cut = (text, longest) => [...String(text ?? "")].slice(0, longest).join("");
/** Others' text, which may run from right to left, within a sentence. */
export const isolated = (text) => `\u2068${text}\u2069`;

/** The texts in this language, else in Dutch. Throws when the host does not answer. */
export async function pluginTexts(language) {
  return new PluginTexts((await tableOf(language, "plugins")).labels, language);
}

/** Texts about a plug-in: a row of the host's `welcome.plugins`. */
class PluginTexts {
  #labels;
  #language;

  constructor(labels, language) {
    this.#labels = labels;
    this.#language = language;
  }

  label(key) {
    return this.#labels[key];
  }

  /** Its name in this language, else in another one, else the one in the configuration. */
  name({ name, names }) {
    const known = [names?.[this.#language], names?.[HOME], names?.en, name];
    return known.map((text) => cut(text, NAME).trim()).find(Boolean) ?? "?";
  }

  icon({ icon }) {
    return cut(icon, ICON).trim();
  }

  /** What is wrong with it, without its name; "" for nothing. */
  wrong({ state, reason }) {
    if (state === "ok") return "";
    return this.#labels[reason] ?? this.#labels[`plugin_${state}`] ?? this.#labels.plugin_lost;
  }

  /** When it is retried; `token`: the host's newest. "" for one that works. */
  again({ state, reason, again }, token) {
    if (state !== "lost") return "";
    if (FOR_PEOPLE.includes(reason)) return this.#labels.plugin_people;
    const left = Math.ceil((again - token) / MS / STEP_S) * STEP_S;
    if (again === null || !(left > 0)) return this.#labels.plugin_now;
    return this.#labels.plugin_again.replace("{s}", left);
  }

  /**
   * If the page's sentence, `message`, is that all is OK: the problem of a plug-in in `rows`, a
   * lost one before one that only reports something; else `message`.
   */
  sentence(message, rows, token) {
    const wrong = ["lost", "degraded"].flatMap((state) => rows.filter((r) => r.state === state));
    if (message.level !== "ok" || wrong.length === 0) return message;
    const [first, ...others] = wrong;
    const also = others.length ? ` ${this.#labels.plugin_also.replace("{n}", others.length)}` : "";
    const text = `${isolated(this.name(first))} ${this.wrong(first)}.${also}`;
    const level = FOR_PEOPLE.includes(first.reason) ? "warning" : "wait";
    const texts = { text, do: this.again(first, token) };
    return { ...message, level, key: "plugin", texts };
  }
}
