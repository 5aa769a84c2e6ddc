// All plug-ins on the caretaker's page: inputs and modes, with their state and own messages.

import { pluginTexts } from "./plugins.js";
import { retryPause } from "./retry.js";

/** The list; all rows have the same size. The page also works without its texts. */
export class PluginList {
  #root;
  #texts = null;
  #missing = false;
  #rows = []; // from the host
  #shown = "";

  constructor(root, language) {
    this.#root = root;
    this.#load(language);
  }

  /** Takes `welcome.plugins`. */
  update(rows) {
    this.#rows = rows.filter(({ kind }) => kind === "input" || kind === "mode");
  }

  /** Shows them; `token`: the host's newest, for computing times. */
  show(token) {
    if (!this.#texts) return;
    const rows = this.#rows.map((row) => this.#columns(row, token));
    const shown = JSON.stringify(rows);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#root.replaceChildren(...rows.map(entry));
    if (rows.length === 0) this.#root.append(this.#texts.label("plugin_none"));
  }

  /** As PluginTexts.sentence(); reports missing texts. */
  sentence(message, token) {
    if (this.#texts) return this.#texts.sentence(message, this.#rows, token);
    const lacks = this.#missing && message.level === "ok";
    return lacks ? { ...message, level: "wait", key: "part_missing" } : message;
  }

  async #load(language) {
    try {
      this.#texts = await pluginTexts(language);
    } catch (error) {
      console.warn(`texts about plug-ins: ${error.message}`);
      this.#missing = true;
      retryPause().then(() => this.#load(language));
    }
  }

  #columns(row, token) {
    const name = `${this.#texts.icon(row)} ${this.#texts.name(row)}`.trim();
    const kind = `${this.#texts.label(`plugin_${row.kind}`)} ${row.name}`;
    const health = this.#texts.wrong(row) || this.#texts.label("plugin_ok");
    const again = this.#texts.again(row, token);
    return { state: row.state, name, kind, health, more: `${again} ${row.detail}`.trim() };
  }
}

function entry({ state, name, kind, health, more }) {
  const made = document.createElement("li");
  made.dataset.state = state;
  for (const [element, text] of [
    ["b", name],
    ["small", kind],
    ["span", health],
    ["p", more],
  ]) {
    const part = document.createElement(element);
    [part.textContent, part.dir] = [text, "auto"];
    made.append(part);
  }
  return made;
}
