// The words of a part of the caretaker's page: its own texts, else the page's.

/** `table`: as tableOf gives it; `unknown`: what stands for a value that is not known. */
export class PartWords {
  constructor(table, strings, unknown) {
    this.table = table;
    this.strings = strings;
    this.unknown = unknown;
  }

  /** A word, with what is in {braces} filled in. */
  label(key, fields = {}) {
    const text = this.table.labels[key] ?? this.strings.label(key) ?? key;
    return text.replace(/{(\w+)}/g, (_, name) => fields[name] ?? this.unknown);
  }

  /** One line: what a reason says, and what to do. */
  reason(key) {
    const { text, do: advice } = this.table.messages[key] ?? this.strings.message(key);
    return `${text} ${advice}`.trim();
  }
}
