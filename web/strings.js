// The pages' texts: loads strings/<language>.json, looks texts up, fills in labels.

import { retryPause } from "./retry.js";

/** The language of texts that another one lacks. */
export const HOME = "nl";

/** The language in the address (?lang=en), else `lang` ("en", "en-GB"), else Dutch. */
export function chosenLanguage(search, lang = HOME) {
  const named = new URLSearchParams(search).get("lang") ?? lang;
  return /^[a-z]{2}(?=-|$)/.exec(named)?.[0] ?? HOME;
}

/** Replaces an element's content by a title and a message's text and advice. */
export function message(element, title, { text, do: advice }) {
  const line = (name, words) => {
    const made = document.createElement("p");
    [made.className, made.textContent] = [name, words];
    return made;
  };
  element.replaceChildren(line("title", title), line("text", text), line("do", advice));
}

/** One language's texts. */
class Strings {
  #table;
  /** One form per number of digits. */
  #numbers = [];
  /** Two letters. */
  language;

  constructor(language, table) {
    this.language = language;
    this.#table = table;
  }

  /** A label of the pages; undefined for an unknown one. */
  label(key) {
    return this.#table.labels[key];
  }

  /** {text, do} for a reason, fault or host key; a newer board's key is shown as it is. */
  message(key) {
    const known = this.#table.messages[key];
    if (known) return known;
    const { text, do: advice } = this.#table.messages.unknown;
    return { text: `${text} (${key})`, do: advice };
  }

  /** A number in this language's format: "2,4" or "2.4". */
  number(value, digits) {
    const form = { minimumFractionDigits: digits, maximumFractionDigits: digits };
    return (this.#numbers[digits] ??= new Intl.NumberFormat(this.language, form)).format(value);
  }

  /** Fills every element of the page that names a label, as its text or as its spoken name. */
  fill(title) {
    document.documentElement.lang = this.language;
    document.title = this.label(title);
    for (const element of document.querySelectorAll("[data-label],[data-spoken]")) {
      const { label, spoken } = element.dataset;
      if (label) element.textContent = this.label(label);
      else element.ariaLabel = this.label(spoken);
    }
  }
}

/**
 * The texts of strings/LANGUAGE.json, or LANGUAGE-PART.json, else the Dutch ones; `language`:
 * theirs. Throws when the host does not answer.
 */
export async function tableOf(language, ...part) {
  for (const name of [language, HOME]) {
    const answer = await fetch(`/strings/${[name, ...part].join("-")}.json`);
    if (answer.ok) return { ...(await answer.json()), language: name };
    if (answer.status !== 404 || name === HOME) throw new Error(`status ${answer.status}`);
  }
}

/**
 * A page's texts, trying again until the host answers. `more` names a second file of texts, for a
 * page with more texts than the driver's ("care": nl-care.json).
 */
export async function loadStrings(lang, more) {
  for (;;) {
    try {
      const { language, ...table } = await tableOf(lang);
      const others = more && (await tableOf(language, more));
      for (const kind in table) Object.assign(table[kind], others?.[kind]);
      return new Strings(language, table);
    } catch (error) {
      console.warn("strings", error);
    }
    await retryPause();
  }
}
