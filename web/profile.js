// A person's own settings: loaded from the host, changed here, stored by the host.

import { retryPause } from "./retry.js";

const JSON_TYPE = { "Content-Type": "application/json" };

/** The host's profiles, with the chosen one, and the limits of every field. */
export class Profiles {
  #table;
  #reloading = false;

  constructor(table) {
    this.#table = table;
  }

  /** Changes with every change at the host. */
  get revision() {
    return this.#table.revision;
  }

  /** The chosen profile: {id, name, dwell_ms, ...}. */
  get current() {
    return this.all.find(({ id }) => id === this.#table.chosen);
  }

  get all() {
    return this.#table.profiles;
  }

  /** {low, high, step} of a number, {choices} of a choice. */
  field(name) {
    return this.#table.fields[name];
  }

  /**
   * Reloads them, once at a time; keeps the present ones when the host does not answer, or when
   * `wanted` returns false by then. Returns whether it took new ones.
   */
  async reload(wanted = () => true) {
    if (this.#reloading) return false;
    this.#reloading = true;
    const table = await ask({ cache: "no-store" });
    this.#reloading = false;
    if (!table.profiles || table.revision === this.revision || !wanted()) return false;
    this.#table = table;
    return true;
  }

  /**
   * Requests a change, see POST /profiles; null, or the reason of a refusal. With `alone`, others'
   * changes are left for the next reload: the revision stays the old one.
   */
  async change(edit, alone = () => false) {
    const body = JSON.stringify(edit);
    const answer = await ask({ method: "POST", headers: JSON_TYPE, body });
    if (!answer.profiles) return answer.reason;
    if (edit.save && alone()) this.#save(edit.save);
    else this.#table = answer;
    return null;
  }

  #save({ id, ...fields }) {
    const profiles = this.all.map((each) => (each.id === id ? { ...each, ...fields } : each));
    this.#table = { ...this.#table, profiles };
  }
}

/** Loads the profiles, trying again until the host answers; a device not paired goes to pair. */
export async function loadProfiles() {
  for (;;) {
    const answer = await ask({ cache: "no-store" });
    if (answer.profiles) return new Profiles(answer);
    if (answer.reason === "not_paired") location.assign("/pair");
    console.warn(`/profiles: ${answer.reason}: ${answer.detail}`);
    await retryPause();
  }
}

async function ask(request) {
  try {
    const answer = await fetch("/profiles", request);
    return await answer.json();
  } catch (error) {
    return { reason: "no_answer", detail: error.message };
  }
}
