// The texts of a part of the caretaker's page: its own, else the page's.

/** `table`: from tableOf(); `unknown`: shown for an unknown value. */
export class PartTexts {
  constructor(table, strings, unknown) {
    this.table = table;
    this.strings = strings;
    this.unknown = unknown;
  }

  /** A text with its {placeholders} filled in. */
  label(key, fields = {}) {
    const text = this.table.labels[key] ?? this.strings.label(key) ?? key;
    return text.replace(/{(\w+)}/g, (_, name) => fields[name] ?? this.unknown);
  }

  /** One line: a reason's text, and what to do. */
  reason(key) {
    const { text, do: advice } = this.table.messages[key] ?? this.strings.message(key);
    return `${text} ${advice}`.trim();
  }
}
