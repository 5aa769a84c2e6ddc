// Pairing on the caretaker's page: a new code with its QR code, the device list, revoking.

import { svg } from "./dom.js";
import { button, element } from "./elements.js";
import { post } from "./post.js";
import { sureButton } from "./sure.js";

const ROLES = ["driver", "caretaker", "viewer"];
/** White around a QR code, in modules: readers need it. */
const QUIET = 4;

/** Rows of "0" and "1" as a picture. */
function qrPicture(rows, spoken) {
  const size = rows.length + 2 * QUIET;
  const parts = rows.flatMap((row, y) =>
    [...row.matchAll(/1+/g)].map(({ index, 0: run }) => {
      const wide = run.length;
      return `M${index + QUIET} ${y + QUIET}h${wide}v1h-${wide}z`;
    }),
  );
  const view = { viewBox: `0 0 ${size} ${size}`, class: "qr", role: "img", "aria-label": spoken };
  const picture = svg("svg", view);
  picture.append(svg("path", { d: parts.join("") }));
  return picture;
}

/** Shows how to pair a new device, and the paired ones. */
export class Pairing {
  #invite;
  #code; // over the page while a code is shown
  #list;
  #strings;
  #refuse;
  #timer = null;

  constructor(invite, list, strings, refuse) {
    this.#invite = invite;
    this.#code = element("div", "code-sheet");
    invite.after(this.#code);
    this.#list = list;
    this.#strings = strings;
    this.#refuse = refuse;
    this.#offer();
  }

  async load() {
    const answer = await this.#ask("/pairing");
    if (answer) this.#showDevices(answer.devices);
  }

  async #ask(path, content) {
    try {
      const answer = await fetch(path, content ? post(content) : { cache: "no-store" });
      const found = await answer.json();
      if (answer.ok) return found;
      this.#refuse(found.reason);
    } catch {
      this.#refuse("no_answer");
    }
    return null;
  }

  /** A button for each role. */
  #offer() {
    clearInterval(this.#timer);
    this.#code.hidden = true;
    this.#code.replaceChildren();
    const label = (key) => this.#strings.label(key);
    const buttons = element("p", "buttons");
    for (const role of ROLES) {
      buttons.append(button(label(`role_${role}`), () => this.#newCode(role)));
    }
    this.#invite.replaceChildren(element("p", "note", label("care_which")), buttons);
  }

  async #newCode(role) {
    const answer = await this.#ask("/pairing/code", { role });
    if (!answer) return;
    clearInterval(this.#timer);
    const label = (key) => this.#strings.label(key);
    const left = element("p", "note");
    const close = () => {
      this.#offer();
      this.load();
    };
    const done = button(label("care_done"), close, "strong");
    const parts = [
      element("p", "", `${label(`role_${role}`)}: ${label("care_scan")}`),
      element("p", "url", answer.url),
      element("p", "code", answer.code),
      left,
      done,
    ];
    if (answer.qr) parts.splice(1, 0, qrPicture(answer.qr, label("care_qr")));
    this.#code.replaceChildren(...parts);
    this.#code.hidden = false;
    const until = performance.now() + 1000 * answer.valid_s;
    const count = () => {
      const seconds = Math.ceil((until - performance.now()) / 1000);
      if (seconds <= 0) return this.#offer();
      const minutes = Math.floor(seconds / 60);
      const rest = String(seconds % 60).padStart(2, "0");
      left.textContent = `${label("care_valid")} ${minutes}:${rest}`;
    };
    this.#timer = setInterval(count, 1000);
    count();
  }

  #showDevices(devices) {
    const label = (key) => this.#strings.label(key);
    const day = (seconds) => new Date(1000 * seconds).toLocaleDateString(this.#strings.language);
    const rows = devices.map(({ id, role, name, last_used: used, you }) => {
      const item = element("li");
      const words = element("p");
      words.append(
        element("b", "", name),
        element("span", "", ` ${label(`role_${role}`)}${you ? `, ${label("care_this")}` : ""}`),
        element("small", "", `${label("care_used")} ${day(used)}`),
      );
      const revoke = sureButton(label("care_revoke"), label("care_sure"), async (button) => {
        if (!(await this.#ask("/pairing/revoke", { id }))) return;
        // The others keep their places, so that a moving finger hits the intended one.
        button.disabled = true;
        item.className = "gone";
      });
      item.append(words, revoke);
      return item;
    });
    this.#list.replaceChildren(...rows);
  }
}
