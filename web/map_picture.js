// A map's picture on a MapView; one that does not arrive is requested again.

const AGAIN_MS = 2000;

export class MapPicture {
  /** The id of the map, "" for none. */
  map = "";
  #version; // of what is shown
  #view;
  #on;
  #failed = false;
  #requestMs = 0;

  /** `on(known)`: where the picture belongs is known; or it does not come. */
  constructor(view, on = () => {}) {
    [this.#view, this.#on] = [view, on];
  }

  /** Shows that map. Call it again and again; `version`: of its file, undefined: not known. */
  show(map, version) {
    const now = performance.now();
    const other = map !== this.map;
    const newer = version !== undefined && version !== this.#version;
    if (!other && !newer && !(this.#failed && now - this.#requestMs >= AGAIN_MS)) return;
    if (other) this.#view.clear();
    if (other || newer) this.#version = version;
    [this.map, this.#failed, this.#requestMs] = [map, false, now];
    if (map) this.#ask(map, now);
  }

  async #ask(map, now) {
    try {
      const answer = await fetch(`/maps/${map}`, { cache: "no-store" });
      if (!answer.ok) throw new Error(`the host answered ${answer.status}`);
      const { picture } = await answer.json();
      if (now !== this.#requestMs) return; // another one meanwhile
      this.#on(true);
      // Under a URL that a page has shown, it would show the same picture again.
      const url = `/maps/${map}.png?${Math.round(now)}`;
      if (!(await this.#view.picture(url, picture))) throw new Error("no picture");
    } catch (error) {
      console.warn(`map ${map}: ${error.message}`);
      if (now !== this.#requestMs) return;
      this.#failed = true;
      this.#on(false);
    }
  }
}
