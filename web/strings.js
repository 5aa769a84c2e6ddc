// The page's words: loads strings/<language>.json, looks words up, fills in labels.

const LANGUAGES = ["nl", "en"];
const RETRY_MS = 2000;

/** The language asked for in the address (?lang=en), Dutch otherwise. */
export function chosenLanguage(search) {
  const asked = new URLSearchParams(search).get("lang");
  return LANGUAGES.includes(asked) ? asked : "nl";
}

/** One language's words. */
export class Strings {
  #table;

  constructor(table) {
    this.#table = table;
  }

  /** A word of the page's own. */
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

  /** Fills every element that names a label. */
  fill(root) {
    for (const element of root.querySelectorAll("[data-label]")) {
      element.textContent = this.label(element.dataset.label);
    }
  }
}

/** Loads a language, trying again until the host answers. */
export async function loadStrings(language) {
  for (;;) {
    try {
      const answer = await fetch(`/strings/${language}.json`);
      if (answer.ok) return new Strings(await answer.json());
      console.warn(`strings/${language}.json: the host answered ${answer.status}`);
    } catch (error) {
      console.warn(`strings/${language}.json: ${error.message}`);
    }
    await new Promise((resume) => setTimeout(resume, RETRY_MS));
  }
}
